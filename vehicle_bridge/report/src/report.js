"use strict";
const buttons = [...document.querySelectorAll("button[data-choose]")];
const shown = new Set(buttons.filter(b => b.getAttribute("aria-pressed") === "true").map(b => b.dataset.choose));
const draw = () => {
  document.querySelectorAll("g[data-lap]").forEach(g => g.classList.toggle("hidden", !shown.has(g.dataset.lap)));
  buttons.forEach(b => b.setAttribute("aria-pressed", shown.has(b.dataset.choose)));
};
buttons.forEach(b => b.addEventListener("click", e => {
  const lap = b.dataset.choose;
  if (e.shiftKey || e.ctrlKey || e.metaKey) { shown.has(lap) ? shown.delete(lap) : shown.add(lap); }
  else if (shown.size === 1 && shown.has(lap)) { shown.clear(); }
  else { shown.clear(); shown.add(lap); }
  draw();
}));
document.querySelectorAll("button[data-all]").forEach(b => b.addEventListener("click", () => {
  shown.clear();
  if (b.dataset.all === "all") buttons.forEach(x => shown.add(x.dataset.choose));
  if (b.dataset.all === "learning") buttons.filter(x => x.dataset.kind === "learning").forEach(x => shown.add(x.dataset.choose));
  draw();
}));
addEventListener("keydown", e => {
  if (e.key !== "ArrowRight" && e.key !== "ArrowLeft" || shown.size !== 1) return;
  const at = buttons.findIndex(b => shown.has(b.dataset.choose)) + (e.key === "ArrowRight" ? 1 : -1);
  if (buttons[at]) { shown.clear(); shown.add(buttons[at].dataset.choose); draw(); e.preventDefault(); }
});
draw();
