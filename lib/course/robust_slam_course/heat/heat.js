(() => {
  const root = document.currentScript.parentElement;
  const { counts, kinds, graphs, percents } = JSON.parse(root.querySelector("[type='application/json']").textContent);
  const body = root.querySelector("tbody");
  const said = root.querySelector(".rs-said");
  const [first] = [said.textContent];
  const columns = [...percents, "mean"];
  const chosen = (name) => root.querySelector(`[name=rs-${name}]:checked`).value;
  const among = (names, one) => (one === "all" ? Object.keys(names).slice(1) : [one]);
  const placeOf = (names, one) => Object.keys(names).indexOf(one) - 1;
  const rowsOf = () => [...body.rows];

  /** Good maps and runs of a method in what is chosen, at a share of outliers or over all. */
  function sum(method, column) {
    let good = 0, runs = 0;
    for (const kind of among(kinds, chosen("kind"))) {
      for (const graph of among(graphs, chosen("graph"))) {
        for (const percent of column === "mean" ? percents : [column]) {
          const place = placeOf(kinds, kind) * (Object.keys(graphs).length - 1) + placeOf(graphs, graph);
          const [some, all] = counts[method][place * percents.length + percents.indexOf(percent)];
          good += some;
          runs += all;
        }
      }
    }
    return { good, runs, share: runs ? good / runs : 0 };
  }

  function show() {
    for (const row of rowsOf()) {
      columns.forEach((column, k) => {
        const { share } = sum(row.dataset.method, column);
        row.cells[k + 1].style.setProperty("--share", share.toFixed(2));
        row.cells[k + 1].textContent = (100 * share).toFixed(0);
      });
    }
    const mean = (row) => sum(row.dataset.method, "mean").share;
    body.append(...rowsOf().sort((one, other) => mean(other) - mean(one)));
    said.textContent = first;
  }

  function say(cell) {
    const { method } = cell.parentElement.dataset;
    const column = columns[cell.cellIndex - 1];
    const { good, runs, share } = sum(method, column);
    const kind = chosen("kind") === "all" ? "outliers of all kinds" : `${chosen("kind")} outliers`;
    const graph = chosen("graph") === "all" ? "all maps" : graphs[chosen("graph")];
    const at = column === "mean" ? kind : `${column} % of ${kind}`;
    said.textContent = `${method}: ${(100 * share).toFixed(0)} % good, ${good} of ${runs} runs, on ${graph} with ${at}.`;
  }

  /** One cell is reached by Tab, the others from it by the arrows. */
  function focus(cell) {
    for (const other of body.querySelectorAll("td[tabindex='0']")) other.tabIndex = -1;
    cell.tabIndex = 0;
    cell.focus();
  }

  const STEPS = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
  body.addEventListener("keydown", (event) => {
    const step = STEPS[event.key];
    const cell = event.target.closest("td");
    if (!step || !cell) return;
    event.preventDefault();
    const next = body.rows[cell.parentElement.sectionRowIndex + step[0]]?.cells[cell.cellIndex + step[1]];
    if (next?.matches("td")) focus(next);
  });
  for (const kind of ["pointerover", "focusin"]) {
    body.addEventListener(kind, ({ target }) => target.closest("td") && say(target.closest("td")));
  }
  for (const cell of body.querySelectorAll("td")) cell.tabIndex = -1;
  body.querySelector("td").tabIndex = 0;
  for (const choice of root.querySelectorAll(".rs-choice")) {
    choice.hidden = false;
    choice.addEventListener("change", show);
  }
  show(); // a browser may remember what was chosen
})();
