// Shows the scene of the page at any of its steps, coloured by any of its fields.
(function () {
  "use strict";
  var view = document.getElementById("view");
  var data = JSON.parse(document.getElementById("view-data").textContent);
  var slider = document.getElementById("step"), play = document.getElementById("play");
  var said = document.getElementById("step-time");
  var shown = data.first, field = data.field, timer = null;
  var body = floats(data.body), slave = floats(data.slave), facets = bytes(data.facets, Int32Array);
  // Rows of the points that the vertices of meshes stand at: several where a crease is.
  var drawnBody = bytes(data.drawn.body, Int32Array), drawnSlave = bytes(data.drawn.slave, Int32Array);

  function bytes(text, Kind) {
    var raw = atob(text), n = raw.length, out = new Uint8Array(n);
    for (var i = 0; i < n; i++) out[i] = raw.charCodeAt(i);
    return new Kind(out.buffer);
  }
  function floats(text) { return bytes(text, Float32Array); }

  // (n, 3) points of the parts of one kind at a step; `first` counts the parts before them.
  function placed(base, sizes, places, first) {
    var out = new Float32Array(base.length), at = 0;
    sizes.forEach(function (n, k) {
      var p = places[first + k];
      if (typeof p === "string") {
        out.set(floats(p), at);
      } else {
        for (var i = at; i < at + 3 * n; i += 3) {
          var x = base[i], y = base[i + 1], z = base[i + 2];
          out[i] = p[0] * x + p[1] * y + p[2] * z + p[9];
          out[i + 1] = p[3] * x + p[4] * y + p[5] * z + p[10];
          out[i + 2] = p[6] * x + p[7] * y + p[8] * z + p[11];
        }
      }
      at += 3 * n;
    });
    return out;
  }
  function column(points, axis, rows) {
    var n = rows ? rows.length : points.length / 3, out = new Float32Array(n);
    for (var i = 0; i < n; i++) out[i] = points[3 * (rows ? rows[i] : i) + axis];
    return out;
  }
  // Values of all slave points, or of all facets where the field is the number of a region.
  function spread(rows, values, count) {
    if (values.length === count && field !== "cluster") return values;
    var cluster = field === "cluster", all = new Float32Array(count).fill(cluster ? -1 : 0);
    rows.forEach(function (row, i) { all[row] = values[i]; });
    if (!cluster) return all;
    var cells = new Float32Array(facets.length / 3);
    for (var i = 0; i < cells.length; i++) {
      cells[i] = Math.min(all[facets[3 * i]], all[facets[3 * i + 1]], all[facets[3 * i + 2]]);
    }
    return cells;
  }
  function pick(values, rows) {
    var out = new Float32Array(rows.length);
    for (var i = 0; i < rows.length; i++) out[i] = values[rows[i]];
    return out;
  }
  function others(rows, count) {
    var inside = new Uint8Array(count), out = [];
    rows.forEach(function (row) { inside[row] = 1; });
    data.idle.forEach(function (row) { inside[row] = 1; });
    for (var i = 0; i < count; i++) if (!inside[i]) out.push(i);
    return out;
  }

  function draw() {
    var frame = data.frames[shown], count = slave.length / 3, meshed = facets.length > 0;
    var bodies = placed(body, data.sizes.body, frame.places, 0);
    var points = placed(slave, data.sizes.slave, frame.places, data.sizes.body.length);
    var rows = bytes(frame.rows, Int32Array), values = floats(frame.values[field]);
    var touching = values.length === count ? pick(values, rows) : values;  // all have it
    var last = view.data.length - (data.ties ? 1 : 0);  // springs come behind all outlines
    var lines = view.data.slice(3, last).map(function (_, k) {
      return frame.lines[k] ? floats(frame.lines[k]) : new Float32Array(0);
    });
    if (data.ties) lines.push(floats(frame.ties));
    var free = meshed ? drawnSlave : others(rows, count), change = { "marker.color": [undefined, undefined, touching] };
    ["x", "y", "z"].forEach(function (name, axis) {
      change[name] = [column(bodies, axis, drawnBody), column(points, axis, free), column(points, axis, rows)]
        .concat(lines.map(function (line) { return column(line, axis); }));
    });
    if (meshed) {
      var colours = spread(rows, values, count);
      change.intensity = [undefined, field === "cluster" ? colours : pick(colours, drawnSlave)];
    }
    var look = data.looks[field];
    if (meshed) Object.keys(look.mesh).forEach(function (name) {
      change[name] = [undefined, look.mesh[name]];
    });
    Object.keys(look.marker).forEach(function (name) {
      change[name] = [undefined, undefined, look.marker[name]];
    });
    Object.keys(change).forEach(function (name) {
      while (change[name].length < view.data.length) change[name].push(undefined);
    });
    Plotly.restyle(view, change, view.data.map(function (_, k) { return k; }));
    mark(data.times[shown]);
    if (slider) {
      slider.value = shown;
      said.textContent = data.labels[shown] + (shown === data.first ? ", the peak" : "");
      slider.setAttribute("aria-valuetext", said.textContent);
    }
  }

  // Figures over time have a line where the scene stands.
  function mark(time) {
    document.querySelectorAll(".js-plotly-plot").forEach(function (plot) {
      (plot.layout.shapes || []).forEach(function (shape, k) {
        if (shape.name !== "shown") return;
        var change = {};
        change["shapes[" + k + "].x0"] = change["shapes[" + k + "].x1"] = time;
        Plotly.relayout(plot, change);
      });
    });
  }

  function stop() {
    clearTimeout(timer);
    timer = null;
    play.textContent = "Play";
  }
  // Steps follow one another as far apart as in the run, six seconds in all.
  function next() {
    var last = data.times.length - 1;
    if (shown === last) return stop();
    var part = (data.times[shown + 1] - data.times[shown]) / (data.times[last] - data.times[0]);
    timer = setTimeout(function () { shown += 1; draw(); next(); }, Math.max(30, 6000 * part));
  }
  if (slider) {
    slider.addEventListener("input", function () { stop(); shown = Number(slider.value); draw(); });
    play.addEventListener("click", function () {
      if (timer !== null) return stop();
      if (shown === data.times.length - 1) { shown = 0; draw(); }
      play.textContent = "Pause";
      next();
    });
  }
  document.querySelectorAll(".choice button").forEach(function (button) {
    button.addEventListener("click", function () {
      var group = button.parentElement;
      if (group.dataset.what === "frame") {
        var change = {};
        ["x", "y", "z"].forEach(function (axis, k) {
          change["scene." + axis + "axis.range"] = data.spans[button.dataset.frame][k];
        });
        Plotly.relayout(view, change);
      } else if (group.dataset.what === "body") {
        var opacity = Number(button.dataset.opacity);
        Plotly.restyle(view, { opacity: opacity, visible: opacity > 0 }, [0]);
      } else {
        field = button.dataset.field;
        draw();
      }
      group.querySelectorAll("button").forEach(function (other) {
        other.setAttribute("aria-pressed", String(other === button));
      });
    });
  });
})();
