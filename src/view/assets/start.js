// The page of `view`: its model is in it. window.splinevox is what tests and other pages may use.

/// Resolves to the App, or to null where the page said why it cannot show anything.
window.splinevox = (async () => {
  try {
    const header = JSON.parse($("header").textContent);
    const bytes = await inflated($("data").textContent);
    $("data").remove();
    const app = new App(header, bytes);
    document.body.classList.remove("loading");
    return app;
  } catch (e) {
    complain(e.message);
    return null;
  }
})();
