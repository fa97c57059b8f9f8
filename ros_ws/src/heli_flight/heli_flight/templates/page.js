(() => {
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const theme = () => ({
    "font.color": css("--ink"),
    "hoverlabel.bgcolor": css("--card"),
    "hoverlabel.bordercolor": css("--line"),
    "hoverlabel.font.color": css("--ink"),
  });
  const drawn = [], overTime = [];
  let shownTime = null, following = false;

  // Zooming one figure in time zooms all of them, also those that are drawn later.
  const follow = (plot) => {
    overTime.push(plot);
    plot.on("plotly_relayout", (change) => {
      if (following) return;
      const start = Object.keys(change).find((key) => /^xaxis\d*\.range\[0\]$/.test(key));
      const all = Object.keys(change).some((key) => /^xaxis\d*\.autorange$/.test(key));
      if (!start && !all) return;
      shownTime = start ? [change[start], change[start.replace("[0]", "[1]")]] : null;
      const update = start ? { "xaxis.range": shownTime } : { "xaxis.autorange": true };
      following = true;
      Promise.all(overTime.filter((other) => other !== plot).map((other) => Plotly.relayout(other, update)))
        .finally(() => { following = false; });
    });
  };
  const waiting = new Set(document.querySelectorAll(".plot"));
  const draw = (plot) => {
    if (!waiting.delete(plot)) return Promise.resolve();
    const { data, layout } = JSON.parse(document.getElementById(plot.id.replace("plot-", "data-")).textContent);
    const timed = "time" in plot.dataset;
    if (timed && shownTime) layout.xaxis = { ...layout.xaxis, range: shownTime, autorange: false };
    plot.style.minHeight = "";
    layout.font = { ...layout.font, color: css("--ink") };
    layout.hoverlabel = { bgcolor: css("--card"), bordercolor: css("--line"), font: { color: css("--ink") } };
    return Plotly.newPlot(plot, data, layout, { responsive: true, displaylogo: false }).then(() => {
      drawn.push(plot);
      if (timed) follow(plot);
    });
  };

  // Two dozen plots at once keep the page from answering: each is drawn shortly before it is seen, the rest one
  // by one when there is time.
  const near = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      near.unobserve(entry.target);
      draw(entry.target);
    }
  }, { rootMargin: "1200px" });
  for (const plot of waiting) near.observe(plot);
  const rest = () => {
    const [next] = waiting;
    if (next) draw(next).finally(() => setTimeout(rest, 60));
  };
  addEventListener("load", () => setTimeout(rest, 500));
  addEventListener("beforeprint", () => { for (const plot of [...waiting]) draw(plot); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const plot of drawn) Plotly.relayout(plot, theme());
  });
})();
