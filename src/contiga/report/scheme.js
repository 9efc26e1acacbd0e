// Figures are made for light pages. Where the system is dark, and not on paper, they are drawn with
// the lightness of all their colours inverted, as the colours of the page are (style.py).
(function () {
  "use strict";
  var system = window.matchMedia("(prefers-color-scheme: dark)"), dark = system.matches;
  var own = { newPlot: Plotly.newPlot, react: Plotly.react, restyle: Plotly.restyle };

  // Of the darkest colours a channel is cut off at 255: each colour is known by its inverse.
  var inverse = {};

  function inverted(colour) {
    if (!/^#[0-9a-f]{6}/i.test(colour)) return colour;
    if (!(colour in inverse)) {
      inverse[colour] = shifted(colour);
      inverse[inverse[colour]] = colour;
    }
    return inverse[colour];
  }
  function shifted(colour) {
    var channels = [1, 3, 5].map(function (k) { return parseInt(colour.slice(k, k + 2), 16); });
    var shift = 280 - Math.max.apply(null, channels) - Math.min.apply(null, channels);
    return channels.reduce(function (text, channel) {
      return text + Math.min(255, channel + shift).toString(16).padStart(2, "0");
    }, "#") + colour.slice(7);
  }
  // Properties are named color, gridcolor, colorscale, vertexcolor, "marker.color" and so on.
  function withInverted(value, isColour) {
    if (typeof value === "string") return isColour ? inverted(value) : value;
    if (Array.isArray(value)) return value.map(function (one) { return withInverted(one, isColour); });
    if (value === null || typeof value !== "object" || value.constructor !== Object) return value;
    var copy = {};
    Object.keys(value).forEach(function (name) {
      copy[name] = withInverted(value[name], isColour || /color/.test(name));
    });
    return copy;
  }
  function inScheme(value) { return dark ? withInverted(value, false) : value; }

  ["newPlot", "react"].forEach(function (name) {
    Plotly[name] = function (plot, data, layout, config) {
      return own[name](plot, inScheme(data), inScheme(layout), config);
    };
  });
  Plotly.restyle = function (plot, change, traces) { return own.restyle(plot, inScheme(change), traces); };

  function turn(to) {
    if (to === dark) return;
    dark = to;
    document.querySelectorAll(".js-plotly-plot").forEach(function (plot) {
      own.react(plot, withInverted(plot.data, false), withInverted(plot.layout, false));
    });
  }
  system.addEventListener("change", function () { turn(system.matches); });
  window.addEventListener("beforeprint", function () { turn(false); });
  window.addEventListener("afterprint", function () { turn(system.matches); });
})();
