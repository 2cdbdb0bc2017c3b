/** Formulas in what a run gave: KaTeX makes MathML of them, which the browser draws. */

let loading = null;

function load(address) {
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = address;
    script.onload = resolve;
    script.onerror = () => reject(new Error(`${address} cannot be loaded`));
    document.head.append(script);
  });
}

/** Draw the formulas of an output; one that cannot be read stays in TeX. */
export async function drawFormulas(output) {
  const places = [...output.querySelectorAll(".math")].filter((place) => !place.querySelector("math"));
  if (!places.length) return;
  await (loading ??= load(new URL("../_static/katex.min.js", import.meta.url)));
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
