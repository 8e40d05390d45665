// Turns every canvas with data-chart into a chart in the page's colours. Nothing moves: a page is also
// looked at as a picture.

for (const canvas of document.querySelectorAll("canvas[data-chart]")) {
  const style = getComputedStyle(document.documentElement);
  const color = name => style.getPropertyValue(name).trim();
  const chart = JSON.parse(canvas.dataset.chart);
  const axis = (text, type) => ({ type, title: { display: true, text, color: color("--soft") },
    grid: { color: color("--line") }, ticks: { color: color("--soft") } });
  new Chart(canvas, {
    type: "scatter",
    data: { datasets: chart.series.map(s => ({ label: s.name, data: s.points, showLine: s.mark !== "dots",
      borderColor: color("--c" + s.color) + (s.mark === "faint" ? "66" : ""),
      backgroundColor: color("--c" + s.color),
      borderWidth: s.mark === "faint" ? 1.2 : 2, pointHitRadius: 6,
      pointRadius: s.mark === "dots" ? (s.points.length > 60 ? 1.5 : 3.5) : 0 })) },
    options: { animation: false, maintainAspectRatio: false,
      scales: { x: axis(chart.x, "linear"), y: axis(chart.y, chart.log ? "logarithmic" : "linear") },
      plugins: { legend: { position: "bottom", labels: { color: color("--soft"), boxWidth: 14 } } } }
  });
}
