// SPDX-License-Identifier: MIT
(async () => {
  const read = (id) => document.getElementById(id).textContent;
  const packed = Uint8Array.from(atob(read("library").trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const library = document.createElement("script");
  library.textContent = await new Response(stream).text();
  document.head.appendChild(library);
  const { paths, limits, size } = JSON.parse(read("run-data"));
  const lateral = paths.filter((path) => !path.vertical), down = paths.filter((path) => path.vertical);
  const config = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d"] };
  const colour = (k, n) => `hsl(${Math.round(n > 1 ? 240 - 230 * k / (n - 1) : 210)}, 70%, 42%)`;
  const layout = (x, y, more = {}) => ({
    height: 420, margin: { l: 60, r: 15, t: 30, b: 50 }, hovermode: "closest", font: { size: 12 },
    xaxis: { title: { text: x }, zeroline: true }, yaxis: { title: { text: y }, zeroline: true }, ...more,
  });
  const part = (id) => {
    const place = document.getElementById(id);
    if (place) place.hidden = false;
    return place;
  };
  const box = (place) => place.appendChild(document.createElement("div"));
  const dash = (path) => (path.role === "held-back" ? "dash" : "solid");
  const line = (path, x, y, k, n, name) => ({
    x, y, name: name || path.name, mode: "lines+markers", marker: { size: 4 },
    line: { color: colour(k, n), dash: dash(path), width: 2 },
  });
  const all = (place, list, x, y, labels, more) =>
    Plotly.newPlot(box(place), list.map((path, k) => line(path, x(path), y(path), k, list.length)), layout(...labels, more), config);

  const controls = (place, list, draw, withSteps) => {
    const bar = place.appendChild(document.createElement("p")), choice = document.createElement("select");
    bar.className = "controls";
    choice.setAttribute("aria-label", "path");
    list.forEach((path, k) => choice.add(new Option(path.name, k)));
    bar.append("path ", choice);
    const slider = document.createElement("input"), words = document.createElement("output");
    slider.type = "range";
    slider.setAttribute("aria-label", "step");
    if (withSteps) bar.append(" state ", slider, " ", words);
    const show = (anew) => {
      const path = list[choice.value], step = Number(slider.value);
      words.textContent = `u ${path.u[step]} mm, rotation ${path.rotation[step]}\u00b0, H ${path.H[step]} MN, M ${path.M[step]} MN m`;
      draw(path, step, anew);
    };
    const begin = () => {
      slider.max = list[choice.value].u.length - 1;
      slider.value = slider.max;
      show(true);
    };
    choice.onchange = begin;
    slider.oninput = () => show(false);
    return begin;
  };

  const range = (path, values) => {
    const within = values.flat().filter((_, k) => !path.edge[k % path.depth.length]);
    const low = Math.min(0, ...within), high = Math.max(0, ...within), room = 0.15 * (high - low || 1);
    return [low - room, high + room];
  };
  const springs = (place) => {
    let curves, profile;
    const begin = controls(place, lateral, (path, step, anew) => {
      const column = (values, k) => values.map((row) => row[k]), n = path.depth.length;
      if (anew) {
        const traces = path.depth.map((depth, k) => ({
          ...line(path, column(path.y, k), column(path.p, k), k, n, `${depth} m${path.edge[k] ? " (edge ring)" : ""}`),
          line: { color: colour(k, n), width: 2, dash: path.edge[k] ? "dot" : "solid" },
        }));
        Plotly.react(curves, traces, layout("y [mm]", "p net [kN/m]", { yaxis: { title: { text: "p net [kN/m]" }, range: range(path, path.p) } }), config);
      }
      const names = [["p", "p [kN/m]"], ["m", "m [kN m/m]"], ["t", "t [kN/m]"], ["y", "y [mm]"]];
      const shape = layout("", "", { showlegend: false, grid: { rows: 1, columns: 4, pattern: "independent" } });
      const traces = names.map(([key, label], k) => {
        const tail = k ? String(k + 1) : "";
        shape["xaxis" + tail] = { title: { text: label }, range: range(path, path[key]) };
        shape["yaxis" + tail] = { autorange: "reversed", title: { text: k ? "" : "depth [m]" } };
        return {
          x: path[key][step], y: path.depth, mode: "lines+markers", name: label, xaxis: "x" + tail, yaxis: "y" + tail,
          marker: { size: 7, symbol: path.edge.map((edge) => (edge ? "circle-open" : "circle")) }, line: { color: "#0072B2" },
        };
      });
      Plotly.react(profile, traces, shape, config);
    }, true);
    curves = box(place);
    profile = box(place);
    begin();
  };

  const tilt = (place) => {
    const free = lateral.filter((path) => path.arm !== undefined), most = Math.max(...free.flatMap((path) => path.rotation.map(Math.abs)));
    const shown = limits.filter((limit) => limit <= 1.5 * most);
    const shapes = shown.map((x) => ({ type: "line", x0: x, x1: x, yref: "paper", y0: 0, y1: 1, line: { dash: "dot", width: 1.5 } }));
    const annotations = shown.map((x) => ({ x, yref: "paper", y: 1.05, text: `${x}\u00b0`, showarrow: false }));
    const sizes = (values) => values.map(Math.abs);
    if (free.length) {
      const named = free.map((path) => ({ ...path, name: `${path.name}: load at ${path.arm} m` }));
      all(place, named, (path) => sizes(path.rotation), (path) => sizes(path.H), ["size of the rotation [deg]", "size of H [MN]"], { shapes, annotations });
    } else place.hidden = true;
  };

  const states = (place) => {
    const known = lateral.filter((path) => path.stress), D = size.outer_diameter, L = size.skirt_length;
    if (!known.length) { place.hidden = true; return; }
    let stress, moved;
    const begin = controls(place, known, (path, step) => {
      const most = Math.max(...Object.values(path.stress).flat(3));
      const traces = Object.entries(path.stress).flatMap(([side, values]) => path.rings.map((depth, k) => ({
        x: path.azimuth, y: values[step][k], name: `${side}, ${depth} m`, mode: "lines+markers", marker: { size: 4 },
        line: { color: colour(k, path.rings.length), dash: side === "outside" ? "solid" : "dot" },
      })));
      Plotly.react(stress, traces, layout("azimuth [deg]: 0 front, 180 back", "normal effective stress [kPa]", { yaxis: { title: { text: "normal effective stress [kPa]" }, range: [-0.03 * most, 1.05 * most] } }), config);
      if (!(D > 0 && L > 0)) return;
      const x = [-D / 2, -D / 2, D / 2, D / 2], z = [L, 0, 0, L], last = path.u.length - 1, turn = Math.PI / 180;
      const across = (k) => x.map((_, i) => path.u[k] / 1e3 - path.rotation[k] * turn * z[i]);
      const along = (k) => x.map((at) => path.w[k] / 1e3 + path.rotation[k] * turn * at);
      const largest = Math.max(...[...across(last), ...along(last)].map(Math.abs)) || 1;
      const factor = Number((0.1 * D / largest).toPrecision(1));
      const shift = (from, by) => from.map((at, i) => at + factor * by[i]);
      Plotly.react(moved, [
        { x, y: z, mode: "lines", name: "at rest", line: { color: "#7a7a7a" } },
        { x: shift(x, across(step)), y: shift(z, along(step)), mode: "lines+markers", name: `moved, ${factor} times`, line: { color: "#D55E00", width: 3 } },
      ], layout("x [m]", "depth [m]", { height: 340, xaxis: { range: [-0.8 * D, 0.8 * D], title: { text: "x [m]" } }, yaxis: { range: [1.3 * L, -0.3 * L], scaleanchor: "x", title: { text: "depth [m]" } } }), config);
    }, true);
    stress = box(place);
    moved = box(place);
    begin();
  };

  const loads = (place) => {
    all(place, lateral, (path) => path.u, (path) => path.H, ["u [mm]", "H [MN]"]);
    all(place, lateral, (path) => path.rotation, (path) => path.M, ["rotation [deg]", "M about the lid centre [MN m]"]);
    if (down.length) all(place, down, (path) => path.w, (path) => path.V, ["w [mm], down +", "V [MN]"]);
  };
  const parts = { springs, loads, tilt, states };
  document.body.classList.add("live");
  for (const [name, draw] of Object.entries(parts)) {
    const place = part(`live-${name}`);
    if (place && (lateral.length || name === "loads")) draw(place);
    else if (place) place.hidden = true;
  }
  document.body.dataset.drawn = String(document.querySelectorAll(".js-plotly-plot").length);
})();
