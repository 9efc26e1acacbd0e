// On paper drawings are as wide as their cards: they scale from the width they were drawn at.
(function () {
  "use strict";
  // A canvas that is not asked to keep what was drawn is empty once it has been shown.
  var context = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    var kept = /^webgl/.test(kind) ? Object.assign({}, options, { preserveDrawingBuffer: true }) : options;
    return context.call(this, kind, kept);
  };
  function each(within, selector, act) { within.querySelectorAll(selector).forEach(act); }

  window.addEventListener("beforeprint", function () {
    each(document, ".svg-container", function (drawing) {
      var width = drawing.clientWidth, height = drawing.clientHeight;
      drawing.style.aspectRatio = width + " / " + height;
      drawing.style.setProperty("--drawn", width + "px");
      each(drawing, "svg[width]", function (svg) {
        var box = svg.getBoundingClientRect();
        svg.setAttribute("viewBox", "0 0 " + box.width + " " + box.height);
      });
      each(drawing, ".gl-container > div", function (scene) {
        var style = scene.style;
        [["left", width], ["width", width], ["top", height], ["height", height]].forEach(function (one) {
          style[one[0]] = 100 * parseFloat(style[one[0]]) / one[1] + "%";
        });
      });
    });
  });
  // The next size is the script's own business again.
  window.addEventListener("afterprint", function () {
    each(document, ".svg-container svg[viewBox]", function (svg) { svg.removeAttribute("viewBox"); });
  });
})();
