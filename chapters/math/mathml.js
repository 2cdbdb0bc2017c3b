/**
 * A formula in TeX as MathML that Chromium, Firefox and Safari draw alike.
 *
 * KaTeX reads the TeX. Its MathML uses what MathML Core has left out, which is put right here:
 * alphabets, the alignment of columns, boxes, and the room about bars and names of functions.
 * The build runs this file, and so does a page whose reader runs a cell that shows formulas.
 */

/** The first letters of Unicode's alphabets, and the letters that it had before. */
const ALPHABETS = {
  "double-struck": [{ A: 0x1d538, a: 0x1d552, 0: 0x1d7d8 },
    { C: "ℂ", H: "ℍ", N: "ℕ", P: "ℙ", Q: "ℚ", R: "ℝ", Z: "ℤ" }],
  script: [{ A: 0x1d49c, a: 0x1d4b6 },
    { B: "ℬ", E: "ℰ", F: "ℱ", H: "ℋ", I: "ℐ", L: "ℒ", M: "ℳ", R: "ℛ", e: "ℯ", g: "ℊ", o: "ℴ" }],
  bold: [{ A: 0x1d400, a: 0x1d41a, 0: 0x1d7ce }, {}],
};
const FUNCTION_APPLICATION = "\u2061";
const ROWS = new Set(["math", "mrow", "mtd", "mstyle", "mpadded"]);
/** Accents as KaTeX writes them, and the signs that are not stretched. */
const ACCENTS = { "~": "˜", "^": "ˆ" };

const textOf = (node) => node.text ?? (node.children ?? []).map(textOf).join("");
/** Several nodes in the place of one; only a row may have their number of children. */
const isFragment = (node) => node.children && !node.type;
const isOperator = (node, text) => node.type === "mo" && (!text || textOf(node) === text);

function inAlphabet(letter, [first, older]) {
  const start = /[A-Z]/.test(letter) ? "A" : /[a-z]/.test(letter) ? "a" : "0";
  if (older[letter] || !/[A-Za-z0-9]/.test(letter) || !first[start]) return older[letter] ?? letter;
  return String.fromCodePoint(first[start] + letter.charCodeAt() - start.charCodeAt());
}

function spell(node) {
  const alphabet = ALPHABETS[node.attributes?.mathvariant];
  if (!alphabet) return;
  node.attributes.mathvariant = "normal";
  for (const child of node.children) {
    child.text = Array.from(child.text, (letter) => inAlphabet(letter, alphabet)).join("");
  }
}

/** Alignment is an attribute of the table in KaTeX, and a matter of style sheets in MathML Core. */
function align(table) {
  const sides = table.attributes.columnalign?.split(" ");
  if (!sides) return;
  table.attributes = { class: "rs-aligned" };
  for (const row of table.children) {
    row.children.forEach((cell, column) => {
      cell.attributes.class = `rs-${sides[column % sides.length]}`;
    });
  }
}

/** Take away the invisible sign behind the name of a function; whether it was there. */
function takeApplication(node) {
  const children = node.children ?? [];
  const kept = children.filter((child) => !isOperator(child, FUNCTION_APPLICATION));
  if (kept.length === children.length) return false;
  node.children = kept;
  return true;
}

/** The name of a function, also with a subscript, has room at its right. */
function separate(row) {
  const parts = row.children.flatMap((child) => (isFragment(child) ? child.children : child));
  row.children = parts.flatMap((child, place) => {
    const isSign = isOperator(child, FUNCTION_APPLICATION);
    const isScript = /^m(sub|sup|subsup|under)$/.test(child.type);
    const isName = isSign || (isScript && takeApplication(child.children[0]));
    const next = parts[place + 1];
    const room = isName && next && !isOperator(next) ? [thinSpace(row.constructor)] : [];
    return isSign ? room : [child, ...room];
  });
}

function thinSpace(Node) {
  const space = new Node("mspace");
  space.setAttribute("width", "0.1667em");
  return space;
}

function improve(node) {
  if ("character" in node) node.character = null; // a space as such, in place of a sign in the font
  if (!node.children) return;
  spell(node);
  if (node.type === "mtable") align(node);
  if (node.type === "menclose") {
    node.type = "mrow";
    node.attributes = { class: "rs-boxed" };
  }
  if (isOperator(node) && /^[∣∥]$/.test(textOf(node)) && node.attributes.stretchy === "false") {
    Object.assign(node.attributes, { lspace: "0", rspace: "0" });
  }
  if (node.type === "mover" && ACCENTS[textOf(node.children[1])]) {
    const accent = node.children[1];
    accent.children[0].text = ACCENTS[textOf(accent)];
    accent.attributes.stretchy = "false";
  }
  if (ROWS.has(node.type)) separate(node);
  else takeApplication(node);
  node.children.forEach(improve);
}

/** An operator with which a formula ends has no room behind it. */
function closeUp(row) {
  const last = row.children.at(-1);
  if (last && isOperator(last) && last.attributes.stretchy !== "false") last.attributes.rspace ??= "0";
  else if (last && ROWS.has(last.type)) closeUp(last);
}

/** Return the `<math>` of a formula; raises KaTeX's error where it cannot be read. */
function mathml(tex, display) {
  const math = katex.__renderToDomTree(tex, {
    displayMode: display, output: "mathml", strict: "error", throwOnError: true,
  }).children[0];
  math.children = [math.children[0].children[0]]; // without the TeX, which browsers do not show
  improve(math);
  closeUp(math);
  return math.toMarkup();
}
