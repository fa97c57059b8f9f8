(() => {
  const plots = [...document.querySelectorAll(".plot")];
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const theme = () => ({
    "font.color": css("--ink"),
    "hoverlabel.bgcolor": css("--card"),
    "hoverlabel.bordercolor": css("--line"),
    "hoverlabel.font.color": css("--ink"),
  });
  const overTime = [];
  let following = false;

  // Zooming one figure in time zooms all of them.
  const follow = (plot) => {
    overTime.push(plot);
    plot.on("plotly_relayout", (change) => {
      if (following) return;
      const start = Object.keys(change).find((key) => /^xaxis\d*\.range\[0\]$/.test(key));
      const all = Object.keys(change).some((key) => /^xaxis\d*\.autorange$/.test(key));
      if (!start && !all) return;
      const update = start
        ? { "xaxis.range": [change[start], change[start.replace("[0]", "[1]")]] }
        : { "xaxis.autorange": true };
      following = true;
      Promise.all(overTime.filter((other) => other !== plot).map((other) => Plotly.relayout(other, update)))
        .finally(() => { following = false; });
    });
  };

  for (const plot of plots) {
    const { data, layout } = JSON.parse(document.getElementById(plot.id.replace("plot-", "data-")).textContent);
    Plotly.newPlot(plot, data, layout, { responsive: true, displaylogo: false }).then(() => {
      Plotly.relayout(plot, theme());
      if (plot.id !== "plot-hover") follow(plot);
    });
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const plot of plots) Plotly.relayout(plot, theme());
  });
})();
