/** Formulas in what a run gave, drawn as the build draws those of the page. */

const STATIC = new URL("../_static/", import.meta.url);
let loading = null;

function load(name) {
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = new URL(name, STATIC);
    script.onload = resolve;
    script.onerror = () => reject(new Error(`${script.src} cannot be loaded`));
    document.head.append(script);
  });
}

/** Draw the formulas of an output; one that cannot be read stays in TeX. */
export async function drawFormulas(output) {
  const places = [...output.querySelectorAll(".math")].filter((place) => !place.querySelector("math"));
  if (!places.length) return;
  loading ??= load("katex.min.js").then(() => load("mathml.js"));
  await loading;
  for (const place of places) {
    const tex = place.textContent.trim();
    try {
      place.innerHTML = window.mathml(tex.slice(2, -2), tex.startsWith("\\["));
    } catch (error) {
      place.title = error.message;
    }
  }
}
