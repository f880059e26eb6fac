"use strict";
// Asks the server for the page's news every second: new data for the figures, and new text.
(async () => {
  await reportPlots.ready;
  const ask = async () => {
    const answer = await fetch("/news", { cache: "no-store" });
    const news = new DOMParser().parseFromString(await answer.text(), "text/html");
    const plots = [...document.querySelectorAll(".plot")];
    const sources = [...news.querySelectorAll(".plot script")];
    if (plots.length !== sources.length) {
      location.reload();
      return;
    }
    for (const [k, source] of sources.entries()) await reportPlots.update(plots[k], JSON.parse(source.textContent));
    document.getElementById("news").replaceWith(document.adoptNode(news.getElementById("news")));
  };
  for (;;) {
    try {
      await ask();
    } catch {
      document.getElementById("news").textContent = "The drive is no longer listened to.";
    }
    await new Promise((resolve) => setTimeout(resolve, 1000));
  }
})();
