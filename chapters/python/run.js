/**
 * Gives each cell of a chapter its button. The rest, Python and the editor, comes at the first
 * click, from the browser's cache if the pointer was on a button before. A page that is opened from a
 * file cannot fetch anything and has no buttons.
 */
(() => {
  const { src, dataset } = document.currentScript;
  if (!/^http/.test(location.protocol) || !window.Worker) return;
  const [cannot, notes] = [dataset.cannot, dataset.notes].map((text) => JSON.parse(text));
  const inputs = [...document.querySelectorAll(".cell[id] .cell_input")];
  inputs.forEach((input, k) => {
    const { id } = input.closest(".cell");
    const bar = document.createElement("div");
    bar.className = "rs-run";
    input.append(bar);
    if (cannot[id]) {
      bar.textContent = cannot[id];
      return;
    }
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = "Edit and run";
    button.title = "Loads Python into this page, about " + dataset.megabytes + " MB, once";
    button.ariaLabel = `Edit and run, code ${k + 1} of ${inputs.length}`;
    button.addEventListener("click", async () => {
      button.disabled = true;
      button.textContent = "Loading the editor …";
      try {
        const { openCell } = await import(new URL("chapter.js", src).href);
        await openCell(id, new URL(dataset.cells, src).href);
        button.textContent = "Edit and run";
      } catch (error) {
        button.disabled = false;
        button.title = String(error);
        button.textContent = "Edit and run (the files could not be loaded; try again)";
      }
    });
    bar.append(notes[id] ?? "", button);
  });

  // Bytes come a moment before they are asked for, when a button has the pointer or the focus.
  const near = ({ target }) => target.closest(".rs-run") && import(new URL("near.js", src).href);
  for (const sign of ["pointerover", "focusin"]) addEventListener(sign, near);
})();
