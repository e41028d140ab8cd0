"use strict";
const all = (selector, from = document) => [...from.querySelectorAll(selector)];
const add = (parent, tag, values) => parent.appendChild(Object.assign(document.createElement(tag), values));

// A click on a head sorts. Cells without a value come last in both directions.
function sort(table, head, column) {
  const down = head.getAttribute("aria-sort") === "ascending";
  all("th", table).forEach(other => other.removeAttribute("aria-sort"));
  head.setAttribute("aria-sort", down ? "descending" : "ascending");
  const key = row => row.cells[column].dataset.value;
  table.tBodies[0].append(...[...table.tBodies[0].rows].sort((a, b) => {
    const x = key(a), y = key(b);
    if (x === "" || y === "") return (x === "") - (y === "");
    const order = isNaN(x) || isNaN(y) ? x.localeCompare(y) : x - y;
    return down ? -order : order;
  }));
}

for (const table of all("table")) {
  all("th", table).forEach((head, column) =>
    head.firstChild.addEventListener("click", () => sort(table, head, column)));
  if (table.tBodies[0].rows.length < 6 || table.id === "answer") continue;
  const search = document.createElement("input");
  Object.assign(search, { type: "search", placeholder: "Filter", ariaLabel: "Filter the rows" });
  table.parentNode.before(search);
  search.addEventListener("input", () => {
    const words = search.value.toLowerCase().split(/\s+/);
    for (const row of table.tBodies[0].rows) {
      row.hidden = !words.every(word => row.textContent.toLowerCase().includes(word));
    }
  });
}

// Rules are switched on and off in tables, in the picture and in plots whose groups are named after them.
const switches = document.getElementById("switches");
const rules = [...new Set(all("[data-rule]").map(part => part.dataset.rule).filter(rule => rule))];
for (const rule of rules.length > 1 ? rules : []) {
  switches.hidden = false;
  const label = add(switches, "label", {});
  const box = add(label, "input", { type: "checkbox", checked: true });
  label.append(" " + rule);
  box.addEventListener("change", () => {
    const parts = all("[data-rule]").filter(part => part.dataset.rule === rule)
      .concat(all("figure [id]").filter(part => part.id === "rule-" + rule || part.id.startsWith("rule-" + rule + "@")));
    parts.forEach(part => part.classList.toggle("off", !box.checked));
  });
}

// The value of the nearest point of the picture under the cursor.
const value = document.getElementById("value");
for (const picture of all("svg.picture")) {
  const points = all("circle", picture);
  picture.addEventListener("pointermove", event => {
    let nearest = null, least = 30;
    for (const point of points) {
      const box = point.getBoundingClientRect();
      const distance = Math.hypot(box.x + box.width / 2 - event.clientX, box.y + box.height / 2 - event.clientY);
      if (distance < least) [nearest, least] = [point, distance];
    }
    value.hidden = nearest === null;
    if (nearest === null) return;
    value.textContent = nearest.querySelector("title").textContent;
    value.style.left = Math.min(event.clientX + 12, innerWidth - value.offsetWidth - 8) + "px";
    value.style.top = event.clientY + 14 + "px";
  });
  picture.addEventListener("pointerleave", () => { value.hidden = true; });
}
