"use strict";
// Draws every figure of the page from its JSON, in the colours of the style sheet, and links figures that share an axis.
const reportPlots = (() => {
  const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  // Colours by value in place of those by name, `var(--ink)`.
  const themed = (value) => {
    if (typeof value === "string") {
      const name = /^var\((--[a-z]+)\)$/.exec(value);
      return name ? color(name[1]) : value;
    }
    if (Array.isArray(value)) {
      return value.some((own) => typeof own === "number") ? value : value.map(themed);
    }
    if (value && typeof value === "object") {
      return Object.fromEntries(Object.entries(value).map(([key, own]) => [key, themed(own)]));
    }
    return value;
  };

  // Zoom and hidden series of a figure as it is drawn now.
  const keepState = (plot, { data, layout }) => {
    for (const key of Object.keys(layout).filter((name) => /^[xy]axis/.test(name))) {
      const { range, autorange } = plot.layout[key];
      Object.assign(layout[key], { range: range && [...range], autorange });
    }
    plot.data.forEach(({ visible }, k) => Object.assign(data[k], visible === undefined ? {} : { visible }));
  };

  const figures = new Map();
  const redraw = (plot) => {
    const figure = figures.get(plot);
    if (plot.data) keepState(plot, figure);
    const { data, layout, config } = figure;
    return Plotly.react(plot, themed(data), themed(layout), config);
  };

  // Draws new data of a figure; a zoom of the user stays.
  const update = (plot, figure) => {
    const was = figures.get(plot).layout.xaxis.range;
    const zoomed = JSON.stringify(was) !== JSON.stringify(plot.layout.xaxis.range);
    const { range } = figure.layout.xaxis;
    figures.set(plot, figure);
    keepState(plot, figure);
    for (const key of Object.keys(figure.layout).filter((name) => /^yaxis/.test(name))) {
      if (!zoomed) Object.assign(figure.layout[key], { range: undefined, autorange: true });
    }
    if (!zoomed) Object.assign(figure.layout.xaxis, { range, autorange: false });
    const { data, layout, config } = figure;
    return Plotly.react(plot, themed(data), themed(layout), config);
  };

  const draw = async (plot) => {
    const source = plot.querySelector("script");
    figures.set(plot, JSON.parse(source.textContent));
    source.remove();
    await redraw(plot);
    // A legend of several lines takes its height from the plots; the figure grows by it.
    const legend = plot.querySelector(".legend");
    const lines = legend ? legend.getBBox().height : 0;
    if (lines > 32) {
      plot.style.height = `${plot.offsetHeight + lines - 20}px`;
      const figure = figures.get(plot);
      figure.layout.margin.t += lines - 20;
      await redraw(plot);
      Plotly.Plots.resize(plot);
    }
  };

  // What a zoom of the horizontal axis changes.
  const change = (event) => {
    if ("xaxis.range[0]" in event) return { "xaxis.range": [event["xaxis.range[0]"], event["xaxis.range[1]"]] };
    if (event["xaxis.range"]) return { "xaxis.range": event["xaxis.range"] };
    return event["xaxis.autorange"] ? { "xaxis.autorange": true } : null;
  };

  const link = (plots) => {
    let following = false;
    for (const plot of plots) {
      const others = plots.filter((other) => other !== plot);
      plot.on("plotly_relayout", async (event) => {
        const update = change(event);
        if (!update || following) return;
        following = true;
        try {
          await Promise.all(others.map((other) => Plotly.relayout(other, { ...update })));
        } finally {
          following = false;
        }
      });
      plot.on("plotly_hover", (event) => {
        const at = event.xvals ? event.xvals[0] : undefined;
        if (typeof at === "number") others.forEach((other) => Plotly.Fx.hover(other, { xval: at }, ["xy"], true));
      });
      plot.on("plotly_unhover", () => others.forEach((other) => Plotly.Fx.unhover(other)));
    }
  };

  const start = async () => {
    const all = [...document.querySelectorAll(".plot")];
    for (const plot of all) await draw(plot);
    for (const group of document.querySelectorAll(".linked")) link([...group.querySelectorAll(".plot")]);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => all.forEach(redraw));
    document.documentElement.dataset.plots = "drawn";
  };

  return { start, update, ready: start() };
})();
