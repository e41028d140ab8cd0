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

// Rules are switched on and off in the tables and in all plots.
const switches = document.getElementById("switches");
const rules = [...new Set(all("[data-rule]").map(part => part.dataset.rule).filter(rule => rule))];
for (const rule of rules.length > 1 ? rules : []) {
  switches.hidden = false;
  const label = add(switches, "label", {});
  const box = add(label, "input", { type: "checkbox", checked: true });
  label.append(" " + rule);
  box.addEventListener("change", () => {
    all("[data-rule]").filter(part => part.dataset.rule === rule)
      .forEach(part => part.classList.toggle("off", !box.checked));
  });
}

// A click on the row of a run switches its points and curves in all plots.
for (const row of all("tr[data-run]")) {
  row.title = "Click: shows or hides this run in the plots";
  row.addEventListener("click", () => {
    const isOff = row.classList.toggle("faint");
    all("svg [data-run]").filter(part => part.dataset.run === row.dataset.run)
      .forEach(part => part.classList.toggle("off-run", isOff));
  });
}

// The points of a plot that have a value: markers with a title, and the corners of curves over time, whose values
// follow from the scale of their axes.
function points_of(plot) {
  const points = all("use", plot).filter(mark => mark.querySelector("title"))
    .map(mark => ({ mark, text: mark.querySelector("title").textContent }));
  for (const curve of all("[data-scale]", plot)) {
    const [a, b, isLogX, c, d, isLogY] = curve.dataset.scale.split(" ").map(Number);
    const units = curve.dataset.units.split("|");
    const shown = (value, isLog, unit) => `${(isLog ? 10 ** value : value).toPrecision(3)} ${unit}`.trim();
    const name = curve.querySelector("title").textContent;
    for (const path of all(":scope > path", curve)) {
      for (const [, x, y] of (path.getAttribute("d") ?? "").matchAll(/[ML] (\S+) (\S+)/g)) {
        const text = `${name}: ${shown(c + d * y, isLogY, units[1])} at ${shown(a + b * x, isLogX, units[0])}`;
        points.push({ mark: curve, x: +x, y: +y, text });
      }
    }
  }
  return points;
}

// The value of the nearest point of a plot under the cursor.
const value = document.getElementById("value");
for (const plot of all("svg")) {
  let points = null;
  const places = () => {
    const toScreen = plot.getScreenCTM();
    return (points ??= points_of(plot)).filter(point => !point.mark.closest(".off, .off-run")).map(point => {
      const box = point.x === undefined ? point.mark.getBoundingClientRect() : null;
      const place = box ? { x: box.x + box.width / 2, y: box.y + box.height / 2 }
        : new DOMPoint(point.x, point.y).matrixTransform(toScreen);
      return { place, text: point.text };
    });
  };
  plot.addEventListener("pointermove", event => {
    let nearest = null, least = 30;
    for (const { place, text } of places()) {
      const distance = Math.hypot(place.x - event.clientX, place.y - event.clientY);
      if (distance < least) [nearest, least] = [text, distance];
    }
    value.hidden = nearest === null;
    if (nearest === null) return;
    value.textContent = nearest;
    value.style.left = Math.min(event.clientX + 12, innerWidth - value.offsetWidth - 8) + "px";
    value.style.top = event.clientY + 14 + "px";
  });
  plot.addEventListener("pointerleave", () => { value.hidden = true; });
}
