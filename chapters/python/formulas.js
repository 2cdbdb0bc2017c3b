/** Formulas in what a run gave: KaTeX makes MathML of them, which the browser draws. */

/** Draw the formulas of an output; one that cannot be read stays in TeX. */
export async function drawFormulas(output) {
  const places = [...output.querySelectorAll(".math")].filter((place) => !place.querySelector("math"));
  if (!places.length) return;
  await import("../_static/katex.min.js"); // as no module it leaves its name with the window
  for (const place of places) {
    const tex = place.textContent.trim();
    try {
      const displayMode = tex.startsWith("\\[");
      window.katex.render(tex.slice(2, -2), place, { displayMode, output: "mathml" });
    } catch (error) {
      place.title = error.message;
    }
  }
}
