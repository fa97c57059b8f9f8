(() => {
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const theme = () => ({
    "font.color": css("--ink"),
    "hoverlabel.bgcolor": css("--card"),
    "hoverlabel.bordercolor": css("--line"),
    "hoverlabel.font.color": css("--ink"),
  });
  const drawn = [];
  const draw = (plot) => {
    const { data, layout } = JSON.parse(document.getElementById(plot.id.replace("plot-", "data-")).textContent);
    plot.style.minHeight = "";
    Plotly.newPlot(plot, data, layout, { responsive: true, displaylogo: false }).then(() => {
      Plotly.relayout(plot, theme());
      drawn.push(plot);
    });
  };

  // Two dozen charts at once keep the page from answering: each is drawn shortly before it is seen.
  const near = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      near.unobserve(entry.target);
      draw(entry.target);
    }
  }, { rootMargin: "1200px" });
  for (const plot of document.querySelectorAll(".plot")) near.observe(plot);
  addEventListener("beforeprint", () => {
    for (const plot of document.querySelectorAll(".plot")) if (!plot.children.length) { near.unobserve(plot); draw(plot); }
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const plot of drawn) Plotly.relayout(plot, theme());
  });
})();
