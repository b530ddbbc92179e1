"use strict";
// Draws the charts of the page's data into its canvases, which stand in the same order.
(() => {
  const AXIS_WIDTH = 64; // of every y axis, so that charts above each other have one time axis
  const root = document.documentElement;
  // colours come from the style sheet, which knows dark mode and paper
  const colour = (name) => getComputedStyle(root).getPropertyValue("--" + name).trim();

  const extent = (chart) => {
    let low = Infinity, high = -Infinity;
    for (const series of [...chart.series, ...(chart.below ? chart.below.series : [])])
      for (const x of series.t) {
        if (x < low) low = x;
        if (x > high) high = x;
      }
    return low < high ? { min: low, max: high } : {};
  };

  const dataset = (series, index, dots) => {
    const ink = colour(series.role) || colour("accent");
    return {
      label: series.name,
      data: series.t.map((x, i) => ({ x, y: series.y[i] })),
      order: -index, // later series lie on top
      showLine: !dots,
      borderColor: ink,
      backgroundColor: ink,
      borderWidth: series.role === "measured" ? 3 : 1.3, // wide enough to be seen beneath
      pointRadius: dots ? 1.6 : 0,
      pointHitRadius: 4,
      tension: 0,
    };
  };

  const axis = (text) => ({
    title: { display: text !== "", text, color: colour("ink") },
    grid: { color: colour("line"), borderColor: colour("line") },
    ticks: { color: colour("ink"), maxRotation: 0, includeBounds: false },
  });

  const options = (x, y, legend) => ({
    animation: false,
    responsive: true,
    maintainAspectRatio: false,
    interaction: { mode: "nearest", axis: "x", intersect: false },
    layout: { padding: { right: 16 } },
    scales: { x, y },
    plugins: {
      legend: {
        display: legend,
        align: "start",
        reverse: true,
        labels: { boxWidth: 18, boxHeight: 2, color: colour("ink") },
      },
      tooltip: { callbacks: { title: ([item]) => (item ? `${x.title.text}: ${item.label}` : "") } },
    },
  });

  // `bare` leaves the x axis to the chart below
  const plot = (chart, range, bare) => {
    const x = { type: "linear", ...axis(chart.x), ...range };
    const y = { type: "linear", ...axis(chart.y) };
    x.afterFit = (scale) => { scale.paddingLeft = scale.paddingRight = 0; };
    y.afterFit = (scale) => { scale.width = AXIS_WIDTH; };
    x.title.display = x.ticks.display = !bare;
    return {
      type: "line",
      data: { datasets: chart.series.map((series, i) => dataset(series, i, chart.form === "dots")) },
      options: { ...options(x, y, chart.series.length > 1), parsing: false, normalized: true },
    };
  };

  const bars = (chart) => {
    const x = { type: "linear", beginAtZero: true, ...axis(chart.x) };
    const y = { type: "category", ...axis("") };
    y.grid.display = y.ticks.autoSkip = false;
    return {
      type: "bar",
      data: {
        labels: chart.labels,
        datasets: [{ data: chart.values, maxBarThickness: 22, backgroundColor: chart.roles ? chart.roles.map(colour) : colour("accent") }],
      },
      options: {
        ...options(x, y, false),
        indexAxis: "y",
        interaction: { mode: "nearest", axis: "y", intersect: false },
      },
    };
  };

  const configurations = (chart) => {
    if (chart.form === "bars") return [bars(chart)];
    const range = extent(chart);
    const upper = plot(chart, range, Boolean(chart.below));
    return chart.below ? [upper, plot(chart.below, range, false)] : [upper];
  };

  const charts = JSON.parse(document.getElementById("charts").textContent);
  const canvases = [...document.querySelectorAll("figure canvas")];
  let drawn = [];
  const draw = () => {
    drawn.forEach((chart) => chart.destroy());
    Chart.defaults.font.size = 0.75 * parseFloat(getComputedStyle(root).fontSize);
    drawn = charts.flatMap(configurations).map((configuration, i) => new Chart(canvases[i], configuration));
  };

  Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
  draw();
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  window.addEventListener("beforeprint", () => { root.dataset.print = ""; draw(); });
  window.addEventListener("afterprint", () => { delete root.dataset.print; draw(); });
})();
