"use strict";
// Draws the page's figures: one after the other, all before printing, anew when the theme changes.
(() => {
  const page = JSON.parse(document.getElementById("page-data").textContent);
  const bytes = (base64) => Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
  const decoded = new Map();
  const array = (name) => {
    if (!decoded.has(name)) {
      decoded.set(name, new Float32Array(bytes(page.arrays[name]).buffer));
    }
    return decoded.get(name);
  };
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const phone = matchMedia("(max-width: 30rem)");
  const touched = matchMedia("(pointer: coarse)");
  let printing = false;
  const colours = () => page.themes[dark.matches && !printing ? "dark" : "light"];
  const complete = (value) => {
    if (Array.isArray(value)) return value.map(complete);
    if (value === null || typeof value !== "object") return value;
    if ("array" in value && typeof value.array === "string") return array(value.array);
    if ("colour" in value) return colours()[value.colour];
    return Object.fromEntries(Object.entries(value).map(([key, inside]) => [key, complete(inside)]));
  };

  // What all charts have alike.
  const template = () => {
    const [colour, clear] = [colours(), "rgba(0,0,0,0)"];
    const axis = {
      gridcolor: colour.grid, linecolor: colour.noise, showline: true, zerolinecolor: colour.noise, automargin: true,
      title: { standoff: 8, font: { size: 12 } }, tickfont: { size: 11, color: colour.quiet },
    };
    const layout = {
      xaxis: axis, yaxis: axis, margin: { l: 52, r: 14, pad: 0 }, showlegend: false, barmode: "overlay",
      hoversubplots: "axis", paper_bgcolor: clear, plot_bgcolor: clear,
      font: { color: colour.ink, size: 12, family: "system-ui, sans-serif" },
      hoverlabel: { bgcolor: colour.surface, bordercolor: colour.grid, font: { color: colour.ink } },
      modebar: { bgcolor: clear, color: colour.quiet, activecolor: colour.ink },
      shapedefaults: { type: "rect", layer: "below", fillcolor: colour.held_out, line: { width: 0 } },
      annotationdefaults: {
        xref: "paper", yref: "paper", xanchor: "left", yanchor: "bottom", yshift: 4, align: "left", showarrow: false,
        font: { size: 12 },
      },
    };
    const bar = {
      orientation: "h", textposition: "auto", insidetextanchor: "end", textangle: 0, constraintext: "none",
      hovertemplate: "%{text}",
    };
    const heatmap = {
      showscale: false, xgap: 2, ygap: 2, colorscale: [[0, colour.after], [0.5, colour.surface], [1, colour.before]],
    };
    return { layout, data: { bar: [bar], heatmap: [heatmap] } };
  };

  window.reportPlayer = complete(page.player);

  const hidden = new Map();
  const draw = (plot) => {
    const figure = page.figures[plot.dataset.figure];
    const off = hidden.get(plot) ?? new Set();
    const data = complete(figure.data).map((trace) => ({ ...trace, visible: !off.has(trace.meta) }));
    const layout = { ...complete(figure.layout), template: template(), uirevision: "kept" };
    // On a touch screen a drag over a chart scrolls the page, and the buttons to zoom with stand above it.
    layout.dragmode = touched.matches ? false : "zoom";
    if (touched.matches) {
      layout.margin.t += 28;
      layout.height += 28;
    }
    if (printing) {
      layout.width = plot.closest(".columns") ? 320 : 660; // what the margins leave of a sheet, or of half of it
      layout.height *= 0.75;
    }
    if (phone.matches) layout.margin.l = 44;
    plot.style.height = `${layout.height}px`;
    Plotly.react(plot, data, layout, {
      responsive: true,
      displaylogo: false,
      modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
    });
    plot.dataset.drawn = "true";
  };

  // Who captures or prints the page waits until it has loaded, and it has not while an image is loading. So images that
  // are none follow each other until all charts are drawn, or one cannot be.
  let drawing = true;
  const hold = () => {
    const image = new Image();
    image.onerror = () => drawing && hold();
    image.src = "data:,";
  };

  // plotly.js takes a second to start; the page is there before.
  const start = async () => {
    const packed = new Blob([bytes(document.getElementById("plotly").textContent)]);
    const script = document.createElement("script");
    script.textContent = await new Response(packed.stream().pipeThrough(new DecompressionStream("gzip"))).text();
    document.body.append(script);
    const next = () => {
      const plot = plots.find((one) => !one.dataset.drawn);
      drawing = false;
      if (!plot) return;
      draw(plot);
      drawing = true;
      setTimeout(next);
    };
    next();
    addEventListener("beforeprint", () => {
      printing = true;
      plots.forEach(draw);
    });
    addEventListener("afterprint", () => {
      printing = false;
      // Without a width of their own, charts keep the sheet's.
      again().forEach((plot) => Plotly.Plots.resize(plot));
    });
  };

  const plots = [...document.querySelectorAll(".plot")];
  const again = () => {
    const drawn = plots.filter((plot) => plot.dataset.drawn);
    drawn.forEach(draw);
    return drawn;
  };
  dark.addEventListener("change", again);

  const axes = (plot) => Object.keys(plot.layout).filter((key) => key.startsWith("xaxis"));
  const moved = (plot, change) => {
    const ranges = {};
    for (const axis of axes(plot)) {
      const [low, high] = plot.layout[axis].range;
      const [from, to] = change(low, high);
      ranges[`${axis}.range[0]`] = from;
      ranges[`${axis}.range[1]`] = to;
    }
    Plotly.relayout(plot, ranges);
  };
  const scaled = (factor) => (low, high) => {
    const middle = (low + high) / 2, half = (factor * (high - low)) / 2;
    return [middle - half, middle + half];
  };
  const shifted = (share) => (low, high) => [low + share * (high - low), high + share * (high - low)];
  const keys = {
    "+": (plot) => moved(plot, scaled(0.5)),
    "-": (plot) => moved(plot, scaled(2)),
    ArrowLeft: (plot) => moved(plot, shifted(-0.25)),
    ArrowRight: (plot) => moved(plot, shifted(0.25)),
    0: (plot) => Plotly.relayout(plot, Object.fromEntries(axes(plot).map((axis) => [`${axis}.autorange`, true]))),
  };
  for (const plot of plots) {
    plot.style.height = `${page.figures[plot.dataset.figure].layout.height}px`;
    plot.addEventListener("keydown", (event) => {
      const act = keys[event.key === "=" ? "+" : event.key];
      if (!act || !plot.dataset.drawn || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      act(plot);
    });
  }
  for (const button of document.querySelectorAll(".legend button")) {
    button.addEventListener("click", () => {
      const plot = button.closest("figure").querySelector(".plot");
      const shown = button.getAttribute("aria-pressed") !== "true";
      button.setAttribute("aria-pressed", String(shown));
      if (!hidden.has(plot)) hidden.set(plot, new Set());
      hidden.get(plot)[shown ? "delete" : "add"](button.dataset.label);
      if (plot.dataset.drawn) draw(plot);
    });
  }
  hold();
  requestAnimationFrame(() => setTimeout(() => start().catch((error) => {
    drawing = false;
    throw error;
  })));
})();
