// The theme scrolls the list of pages so far that its head is gone: the page that is read shall be
// seen, and no more. It does so when the page is parsed, thus this waits for what comes later.
addEventListener("load", () => {
  document.querySelector(".bd-links .current > a")?.scrollIntoView({ block: "nearest" });
});
