"use strict";
// The page's news: new data for the figures, and new text. A server is asked for them every second; a page that has
// this one in a frame sends them.
(async () => {
  await reportPlots.ready;
  const show = async (text) => {
    const news = new DOMParser().parseFromString(text, "text/html");
    const plots = [...document.querySelectorAll(".plot")];
    const sources = [...news.querySelectorAll(".plot script")];
    if (plots.length !== sources.length) {
      // A frame is given a new page.
      if (parent === window) location.reload();
      return;
    }
    for (const [k, source] of sources.entries()) await reportPlots.update(plots[k], JSON.parse(source.textContent));
    document.getElementById("news").replaceWith(document.adoptNode(news.getElementById("news")));
  };
  if (parent !== window) {
    let last = null, isShowing = false;
    // Only the last of those that come meanwhile.
    addEventListener("message", async ({ data }) => {
      last = data;
      if (isShowing) return;
      isShowing = true;
      while (last !== null) {
        const text = last;
        last = null;
        await show(text);
      }
      isShowing = false;
    });
    parent.postMessage("ready", "*");
    return;
  }
  for (;;) {
    try {
      const answer = await fetch("/news", { cache: "no-store" });
      await show(await answer.text());
    } catch {
      document.getElementById("news").textContent = "The drive is no longer listened to.";
    }
    await new Promise((resolve) => setTimeout(resolve, 1000));
  }
})();
