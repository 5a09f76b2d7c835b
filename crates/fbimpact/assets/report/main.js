// Puts the parts of the page to work. What fails leaves the drawings of the page where they are.
"use strict";

report.main = async function () {
  const head = JSON.parse(document.getElementById("head").textContent);
  report.head = head;
  document.documentElement.classList.add("live");
  try {
    await report.draw_charts(head.charts);
  } catch (error) {
    document.documentElement.classList.remove("live");
    console.error("figures: " + error);
  }
  report.viewers = [];
  for (let i = 0; i < head.scenes.length; i++) {
    if (!head.scenes[i]) continue;
    const place = document.getElementById("scene-" + i);
    try {
      report.viewers.push(await report.view(head.scenes[i], place));
    } catch (error) {
      const note = place.querySelector(".note");
      if (note) note.textContent = "The bodies cannot be drawn here (" + error.message + "); the figures below show the same run.";
    }
  }
  report.follow = (time) => report.viewers.forEach((viewer) => viewer.go_to(time));
  if (location.hash === "#test") report.test();
};

// What a test without hands can ask: values decoded and drawn, as JSON in the page.
report.test = function () {
  const out = document.createElement("pre");
  out.id = "test";
  const viewers = report.viewers.map((viewer) => viewer.probe());
  out.textContent = JSON.stringify({ charts: report.charts.length, viewers });
  document.body.append(out);
};

report.main();
