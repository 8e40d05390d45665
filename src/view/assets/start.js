// The page of `view`: its model is in it. window.splinevox is what tests and other pages may use.

/// Resolves to the App, or to null where the page said why it cannot show anything.
window.splinevox = (async () => {
  $("wait").textContent = "Unpacking\u2026";
  try {
    const header = JSON.parse($("header").textContent);
    document.body.style.setProperty("--behind", "#" + hexOf(ownBackground(header)));
    const bytes = await inflated($("data").textContent);
    $("data").remove();
    const app = new App(header, bytes);
    app.opened = () => app.open();
    return app;
  } catch (e) {
    complain(e.message);
    return null;
  }
})();
