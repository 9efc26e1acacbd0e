// The page of a study: a table that sorts, all variables at once, responses, convergence.
(function () {
  "use strict";
  var data = JSON.parse(document.getElementById("study-data").textContent);
  var n = data.count, columns = data.columns, byName = {}, config = data.config;
  columns.forEach(function (column) { byName[column.name] = column; });
  var numbers = columns.filter(function (column) { return column.role === "quantity"; });
  var variables = columns.filter(function (column) { return column.role === "variable"; });
  var chosen = [], NARROW = 640;

  function $(id) { return document.getElementById(id); }
  function link(row) { return data.links[row]; }
  function text(column, row) {
    var value = column.values[row];
    if (column.texts) return column.texts[value];
    return value === null ? "–" : String(value);
  }
  function label(column) { return column.unit ? column.name + " [" + column.unit + "]" : column.name; }
  function told(row) {
    var said = variables.concat(numbers).map(function (column) {
      return column.name + " " + text(column, row);
    });
    return "case " + byName.case.values[row] + "<br>" + said.join("<br>");
  }
  function options(select, list, first) {
    list.forEach(function (column, k) {
      var option = document.createElement("option");
      option.value = column.name;
      option.textContent = column.name;
      option.selected = k === first;
      select.appendChild(option);
    });
    return select;
  }
  function axis(column) {
    var made = { title: { text: label(column) }, gridcolor: data.look.grid, zeroline: false, automargin: true };
    if (column.texts) {
      made.tickvals = column.texts.map(function (_, k) { return k; });
      made.ticktext = column.texts;
    }
    return made;
  }
  function layout(x, y, more) {
    var made = {
      template: "none", height: 420, margin: { l: 70, r: 20, t: 20, b: 55 }, xaxis: x, yaxis: y,
      font: { family: data.look.font, size: 13, color: data.look.ink }, showlegend: false,
      hovermode: "closest", paper_bgcolor: data.look.paper, plot_bgcolor: data.look.paper
    };
    Object.keys(more || {}).forEach(function (key) { made[key] = more[key]; });
    return made;
  }
  // A click on a point leads to the report of its case; customdata are the rows.
  function links(plot) {
    if (plot.removeAllListeners) plot.removeAllListeners("plotly_click");
    plot.on("plotly_click", function (event) {
      var row = event.points[0].customdata;
      if (row !== undefined && row !== null) window.open(link(row), "_blank");
    });
  }
  function all() {
    var rows = [];
    for (var i = 0; i < n; i++) rows.push(i);
    return rows;
  }
  function marker(column) {
    return {
      size: n > 2000 ? 4 : 7, line: { width: n > 2000 ? 0 : 0.8, color: data.look.muted }, color: column.values, colorscale: data.look.scale, opacity: 0.9,
      colorbar: { title: { text: label(column), side: "right" }, thickness: 12, outlinewidth: 0 }
    };
  }

  // All variables and quantities at once.
  function parallel() {
    var colour = byName[$("parallel-colour").value], drawn = variables.concat(numbers);
    // A case without a value would be a line that ends nowhere.
    var whole = all().filter(function (row) {
      return drawn.every(function (column) { return column.values[row] !== null; });
    });
    function of(column) { return whole.map(function (row) { return column.values[row]; }); }
    // Labels that would meet are slanted, and cut where they are long.
    var slanted = drawn.length > 6 || $("parallel").clientWidth < 150 * drawn.length;
    var most = slanted ? 18 : 22, angle = $("parallel").clientWidth < 90 * drawn.length ? -45 : -20;
    var dimensions = drawn.map(function (column) {
      var cut = column.name.length > most ? "…" + column.name.slice(1 - most) : column.name;
      var made = { label: cut, values: of(column) };
      if (column.texts) {
        made.tickvals = column.texts.map(function (_, k) { return k; });
        made.ticktext = column.texts;
      }
      return made;
    });
    Plotly.react("parallel", [{
      type: "parcoords", dimensions: dimensions, labelangle: slanted ? angle : 0,
      line: { color: of(colour), colorscale: data.look.scale, showscale: true,
        colorbar: { title: { text: label(colour), side: "right" }, thickness: 12, outlinewidth: 0 } }
    }], layout({}, {}, { margin: { l: 70, r: 40, t: slanted ? 140 : 60, b: 30 } }), config);
  }

  // One quantity over one variable, coloured by anything.
  function response() {
    var x = byName[$("response-x").value], y = byName[$("response-y").value];
    var colour = byName[$("response-colour").value];
    Plotly.react("response", [{
      type: "scattergl", mode: "markers", x: x.values, y: y.values, customdata: all(),
      text: all().map(told), hovertemplate: "%{text}<extra></extra>", marker: marker(colour)
    }], layout(axis(x), axis(y)), config);
    links($("response"));
  }
  // One quantity over two variables.
  function surface() {
    var x = byName[$("surface-x").value], y = byName[$("surface-y").value];
    var z = byName[$("surface-z").value], traces = [], grid = gridOf(x, y, z);
    if (grid) traces.push({
      type: "heatmap", x: grid.x, y: grid.y, z: grid.z, colorscale: data.look.scale, showscale: false,
      zsmooth: "best", hoverinfo: "skip", zmin: grid.least, zmax: grid.most
    });
    var points = marker(z);
    points.size = n > 2000 ? 5 : 11;
    points.line = { width: n > 2000 ? 0 : 1, color: data.look.paper };
    traces.push({
      type: "scattergl", mode: "markers", x: x.values, y: y.values, customdata: all(),
      text: all().map(told), hovertemplate: "%{text}<extra></extra>", marker: points
    });
    Plotly.react("surface", traces, layout(axis(x), axis(y)), config);
    links($("surface"));
  }
  // Mean values over a grid where two variables have few values, and every pair of them a case.
  function gridOf(x, y, z) {
    function few(column) {
      var seen = Array.from(new Set(column.values)).sort(function (a, b) { return a - b; });
      return seen.length > 1 && seen.length <= 60 ? seen : null;
    }
    var xs = few(x), ys = few(y);
    if (!xs || !ys || x === y) return null;
    var sum = ys.map(function () { return xs.map(function () { return 0; }); });
    var count = ys.map(function () { return xs.map(function () { return 0; }); });
    for (var i = 0; i < n; i++) {
      if (z.values[i] === null) continue;
      var a = ys.indexOf(y.values[i]), b = xs.indexOf(x.values[i]);
      sum[a][b] += z.values[i];
      count[a][b] += 1;
    }
    if (count.some(function (row) { return row.indexOf(0) >= 0; })) return null;
    var told = z.values.filter(function (value) { return value !== null; });
    return {
      x: xs, y: ys, least: told.reduce(function (a, b) { return Math.min(a, b); }),
      most: told.reduce(function (a, b) { return Math.max(a, b); }),
      z: sum.map(function (row, a) { return row.map(function (value, b) { return value / count[a][b]; }); })
    };
  }

  // A quantity over ever finer meshes, and its distance from the finest.
  function convergence() {
    var name = $("convergence-y").value, found = data.convergence;
    var lines = found.lines[name], grey = lines.length > 12;
    var values = lines.map(function (line, k) {
      return {
        type: "scatter", mode: "lines+markers", x: found.levels, y: line.values, customdata: line.rows,
        name: line.label, hovertemplate: line.label + "<br>%{y}<extra></extra>",
        line: { color: grey ? data.look.muted : data.look.lines[k % data.look.lines.length], width: 1.6 }
      };
    });
    var away = lines.map(function (line, k) {
      return {
        type: "scatter", mode: "lines+markers", x: found.sizes.slice(0, -1), y: line.errors, customdata: line.rows,
        name: line.label, hovertemplate: line.label + "<br>%{y}<extra></extra>", line: values[k].line
      };
    });
    var x = { title: { text: found.name }, type: "category", gridcolor: data.look.grid };
    var size = { title: { text: "size of the mesh, coarsest = 1" }, type: "log", gridcolor: data.look.grid };
    Plotly.react("convergence", values, layout(x, axis(byName[name])), config);
    Plotly.react("errors", away, layout(size, {
      title: { text: "distance from the finest" }, type: "log", gridcolor: data.look.grid,
      exponentformat: "power", automargin: true
    }), config);
    links($("convergence"));
    links($("errors"));
    $("orders").textContent = lines.map(function (line) { return line.said; }).slice(0, 6).join("; ");
  }

  // What the optimiser found, case after case.
  function course() {
    var goal = data.goal, y = byName[goal.quantity];
    Plotly.react("course", [
      { type: "scattergl", mode: "markers", x: byName.case.values, y: y.values, customdata: all(),
        text: all().map(told), hovertemplate: "%{text}<extra></extra>",
        marker: { size: 7, color: goal.within.map(function (inside) {
          return inside ? data.look.lines[0] : data.look.faint; }) } },
      { type: "scatter", mode: "lines", x: goal.best.x, y: goal.best.y, hoverinfo: "skip",
        line: { shape: "hv", color: data.look.lines[1], width: 1.6 } }
    ], layout({ title: { text: "case" }, gridcolor: data.look.grid, zeroline: false }, axis(y)), config);
    links($("course"));
  }

  // The table: only the rows in sight are in the page, on paper all.
  var order = all(), sorted = null, rising = true, height = 33, printing = false;
  var box = $("rows"), head = $("rows-head"), body = $("rows-body"), above = $("rows-above"), below = $("rows-below");
  function compare(column) {
    return function (a, b) {
      var p = column.values[a], q = column.values[b];
      if (column.texts && p !== null && q !== null) { p = column.texts[p]; q = column.texts[q]; }
      if (p === q) return a - b;
      if (p === null) return 1;
      if (q === null) return -1;
      return (p < q ? -1 : 1) * (rising ? 1 : -1);
    };
  }
  function sortBy(column) {
    rising = sorted === column ? !rising : true;
    sorted = column;
    order = all().sort(compare(column));
    box.scrollTop = 0;
    heads();
    rows();
  }
  function heads() {
    head.textContent = "";
    columns.forEach(function (column) {
      var cell = document.createElement("th"), button = document.createElement("button");
      cell.className = column.texts ? "" : "number";
      cell.setAttribute("aria-sort", sorted !== column ? "none" : rising ? "ascending" : "descending");
      button.textContent = label(column) + (sorted !== column ? "" : rising ? " ▲" : " ▼");
      button.addEventListener("click", function () { sortBy(column); });
      cell.appendChild(button);
      head.appendChild(cell);
    });
  }
  function rows() {
    var first = printing ? 0 : Math.max(0, Math.floor(box.scrollTop / height) - 8);
    var last = printing ? n : Math.min(n, first + Math.ceil(box.clientHeight / height) + 16);
    above.style.height = first * height + "px";
    below.style.height = (n - last) * height + "px";
    body.textContent = "";
    for (var k = first; k < last; k++) body.appendChild(rowOf(order[k]));
  }
  function rowOf(row) {
    var line = document.createElement("tr");
    line.className = chosen.indexOf(row) >= 0 ? "chosen" : "";
    line.addEventListener("click", function () { choose(row); });
    columns.forEach(function (column) {
      var cell = document.createElement("td");
      cell.className = column.texts ? "" : "number";
      if (column.name === "case") {
        var anchor = document.createElement("a");
        anchor.href = link(row);
        anchor.textContent = text(column, row);
        cell.appendChild(anchor);
      } else {
        cell.textContent = text(column, row);
        cell.title = text(column, row);
      }
      line.appendChild(cell);
    });
    return line;
  }
  function choose(row) {
    chosen = chosen.indexOf(row) >= 0 ? chosen.filter(function (one) { return one !== row; })
      : chosen.concat([row]).slice(-20);
    $("compare").textContent = chosen.length < 2 ? "Click rows to compare them, up to 20."
      : "contiga compare " + chosen.map(function (one) { return data.folders[one]; }).join(" ") + " -o compare.html";
    rows();
  }

  function ready(ids, draw) {
    ids.forEach(function (id) { $(id).addEventListener("change", draw); });
    draw();
  }
  heads();
  rows();
  box.addEventListener("scroll", function () { window.requestAnimationFrame(rows); });
  ["beforeprint", "afterprint"].forEach(function (name) {
    window.addEventListener(name, function () { printing = name === "beforeprint"; rows(); });
  });
  options($("parallel-colour"), numbers, 0);
  ready(["parallel-colour"], parallel);
  options($("response-x"), variables, 0);
  options($("response-y"), numbers, 0);
  options($("response-colour"), variables.concat(numbers), variables.length > 1 ? 1 : 0);
  ready(["response-x", "response-y", "response-colour"], response);
  if (variables.length > 1) {
    options($("surface-x"), variables, 0);
    options($("surface-y"), variables, 1);
    options($("surface-z"), numbers, 0);
    ready(["surface-x", "surface-y", "surface-z"], surface);
  }
  if (data.convergence) {
    options($("convergence-y"), numbers, 0);
    ready(["convergence-y"], convergence);
  }
  if (data.goal) course();
  // The camera fits what it sees by its height: where the room is as wide as high it stands back,
  // and the bar of colours lies below.
  function turned() {
    var layout = data.map.layout, width = $("map").clientWidth, eye = layout.scene.camera.eye;
    if (width < NARROW) {
      Object.keys(eye).forEach(function (axis) { eye[axis] *= data.map.back; });
      layout.height = width + 70;
      layout.margin.b = 80;
      var bar = data.map.data[1].marker.colorbar;
      Object.assign(bar, { orientation: "h", y: 0, yanchor: "top", ypad: 8, len: 0.92 });
      bar.title.side = "top";
    }
    Plotly.newPlot("map", data.map.data, layout, config);
    links($("map"));
  }
  if (data.map) turned();
})();
