// Paper is white and cannot be opened: a page that is dark on the screen is printed light, and a box
// that belongs on paper is open there.
addEventListener("beforeprint", () => {
  const { dataset } = document.documentElement, { theme } = dataset;
  const closed = [...document.querySelectorAll("details.rs-on-paper:not([open])")];
  dataset.theme = "light";
  for (const box of closed) box.open = true;
  addEventListener("afterprint", () => {
    dataset.theme = theme;
    for (const box of closed) box.open = false;
  }, { once: true });
});
