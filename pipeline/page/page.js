// SPDX-License-Identifier: Apache-2.0
// The viewer of `fewray report`: two of the pictures lie over each other, the left one cut off at the divider. All that it
// needs stands in the document: figure.picture with img.shown, perhaps img.error, and data-name.
"use strict";

(function pictures() {
  const stage = document.querySelector(".pictures");
  if (!stage) return;
  const figures = [...stage.querySelectorAll("figure")];
  const pair = document.getElementById("pair").dataset;
  const state = { left: +pair.left, right: +pair.right, split: 50, zoom: 1, x: 0, y: 0, errors: false };

  const parts = document.getElementById("viewer").content.cloneNode(true);
  const [tools, over, keys] = parts.children;
  stage.before(tools);
  stage.append(over);
  const below = stage.nextElementSibling && stage.nextElementSibling.matches(".legend") ? stage.nextElementSibling : stage;
  below.after(keys);
  stage.classList.add("live");
  stage.id = "stage";

  const byId = (id) => document.getElementById(id);
  const handle = byId("handle");
  const hasErrors = stage.querySelector("img.error") !== null;
  const names = figures.map((figure) => figure.dataset.name);
  for (const select of [byId("left"), byId("right")]) {
    names.forEach((name, i) => select.add(new Option(i < 9 ? `${i + 1} ${name}` : name, i)));
    select.addEventListener("change", () => choose(select.id, +select.value));
  }
  byId("errors").hidden = !hasErrors;
  byId("errors").addEventListener("click", toggleErrors);
  byId("swap").addEventListener("click", swap);
  byId("in").addEventListener("click", () => zoomBy(2));
  byId("out").addEventListener("click", () => zoomBy(0.5));
  byId("fit").addEventListener("click", () => zoomTo(1, 0, 0));

  // --- what the state looks like

  function update() {
    figures.forEach((figure, i) => {
      figure.classList.toggle("left", i === state.left);
      figure.classList.toggle("right", i === state.right);
    });
    const style = stage.style;
    style.setProperty("--split", state.split + "%");
    style.setProperty("--zoom", state.zoom);
    style.setProperty("--x", state.x);
    style.setProperty("--y", state.y);
    const scale = (stage.clientWidth * state.zoom) / width();
    stage.classList.toggle("zoomed", state.zoom > 1);
    stage.classList.toggle("pixels", scale * devicePixelRatio >= 2);
    stage.classList.toggle("errors", state.errors);
    byId("errors").setAttribute("aria-pressed", state.errors);
    byId("level").textContent = Math.round(100 * scale) + " %";
    for (const side of ["left", "right"]) {
      byId(side).value = state[side];
      const of = state.errors && figures[state[side]].querySelector(".error") ? "error: " : "";
      byId(side + "-name").textContent = of + names[state[side]];
    }
    const split = Math.round(state.split);
    handle.setAttribute("aria-valuenow", split);
    handle.setAttribute("aria-valuetext", `${split} % ${names[state.left]}, ${100 - split} % ${names[state.right]}`);
  }

  const width = () => +getComputedStyle(stage).getPropertyValue("--w");
  const clamp = (value, least, most) => Math.min(Math.max(value, least), most);

  function choose(side, index) {
    if (index >= figures.length) return;
    state[side] = index;
    update();
  }
  function swap() {
    [state.left, state.right] = [state.right, state.left];
    update();
  }
  function toggleErrors() {
    state.errors = hasErrors && !state.errors;
    update();
  }
  function splitAt(percent) {
    state.split = clamp(percent, 0, 100);
    update();
  }
  // px, py: the place that stays, as shares of the stage. Up to 32 screen pixels a pixel.
  function zoomTo(zoom, px, py) {
    const most = Math.max(8, (32 * width()) / stage.clientWidth);
    const next = clamp(zoom, 1, most);
    state.x = px - ((px - state.x) * next) / state.zoom;
    state.y = py - ((py - state.y) * next) / state.zoom;
    state.zoom = next;
    moveBy(0, 0);
  }
  const zoomBy = (factor) => zoomTo(state.zoom * factor, 0.5, 0.5);
  function moveBy(dx, dy) {
    state.x = clamp(state.x + dx, 1 - state.zoom, 0);
    state.y = clamp(state.y + dy, 1 - state.zoom, 0);
    update();
  }

  // --- mouse, touch and pen: one pointer moves the divider or the enlarged picture, two zoom

  const pointers = new Map(); // id to place, as shares of the stage
  let action = null; // "split", "move", "pinch"; "wait": a touch that may become a scroll of the page
  let start = null;
  let tap = { time: 0, x: 0, y: 0 };

  function place(event) {
    const box = stage.getBoundingClientRect();
    return { x: (event.clientX - box.left) / box.width, y: (event.clientY - box.top) / box.height };
  }
  function fingers() {
    const [a, b] = [...pointers.values()];
    const box = stage.getBoundingClientRect();
    const apart = Math.hypot((a.x - b.x) * box.width, (a.y - b.y) * box.height);
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, apart: Math.max(apart, 1) };
  }

  stage.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || pointers.size === 2) return;
    pointers.set(event.pointerId, place(event));
    stage.setPointerCapture(event.pointerId);
    handle.focus({ preventScroll: true });
    if (pointers.size === 2) {
      action = "pinch";
      start = fingers();
      return;
    }
    const onHandle = handle.contains(event.target);
    const { clientX, clientY } = event;
    start = { ...place(event), clientX, clientY, moved: false, offset: onHandle ? state.split - 100 * place(event).x : 0 };
    action = onHandle ? "split" : state.zoom > 1 ? "move" : event.pointerType === "touch" ? "wait" : "split";
    if (action === "split" && !onHandle) splitAt(100 * start.x);
    event.preventDefault();
  });

  stage.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = place(event);
    pointers.set(event.pointerId, now);
    if (action === "pinch") {
      const next = fingers();
      zoomTo((state.zoom * next.apart) / start.apart, start.x, start.y);
      moveBy(next.x - start.x, next.y - start.y);
      start = next;
      return;
    }
    const right = Math.abs(event.clientX - start.clientX), down = Math.abs(event.clientY - start.clientY);
    start.moved = start.moved || Math.max(right, down) > 6;
    if (action === "wait" && start.moved) action = right > down ? "split" : null;
    if (action === "split") splitAt(100 * now.x + start.offset);
    if (action === "move") moveBy(now.x - before.x, now.y - before.y);
  });

  function release(event) {
    if (!pointers.delete(event.pointerId)) return;
    if (action === "pinch") {
      // the finger that stays moves the picture
      const [rest] = pointers.values();
      action = rest ? "move" : null;
      start = { ...rest, moved: true, offset: 0 };
      return;
    }
    action = null;
    if (event.type === "pointerup" && !start.moved) tapped(event);
  }
  stage.addEventListener("pointerup", release);
  stage.addEventListener("pointercancel", release);

  function tapped(event) {
    const near = Math.hypot(event.clientX - tap.x, event.clientY - tap.y) < 30;
    const twice = near && event.timeStamp - tap.time < 350;
    tap = { time: twice ? 0 : event.timeStamp, x: event.clientX, y: event.clientY };
    const { x, y } = place(event);
    if (twice) zoomTo(state.zoom > 1 ? 1 : 4, x, y);
  }

  // Two fingers are ours, also where one would scroll the page.
  stage.addEventListener("touchmove", (event) => event.touches.length > 1 && event.preventDefault(), { passive: false });

  stage.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !stage.contains(document.activeElement)) return;
    event.preventDefault();
    const { x, y } = place(event);
    const lines = event.deltaMode === 1 ? 16 : 1;
    zoomTo(state.zoom * Math.exp(-clamp(event.deltaY * lines, -200, 200) / 300), x, y);
  }, { passive: false });

  // --- keys

  const steps = {
    ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10, Home: -100, End: 100,
  };
  const moves = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

  handle.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in steps)) return;
    const move = moves[event.key];
    if (event.shiftKey && move) moveBy(0.1 * move[0], 0.1 * move[1]);
    else splitAt(state.split + steps[event.key]);
    event.preventDefault();
  });

  const letters = {
    e: toggleErrors, x: swap, "+": () => zoomBy(2), "=": () => zoomBy(2), "-": () => zoomBy(0.5), 0: () => zoomTo(1, 0, 0),
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("select, input")) return;
    const digit = /^(Digit|Numpad)([1-9])$/.exec(event.code);
    const letter = letters[event.key.toLowerCase()];
    if (digit) choose(event.shiftKey ? "left" : "right", digit[2] - 1);
    else if (letter) letter();
    else return;
    event.preventDefault();
  });

  new ResizeObserver(update).observe(stage);
  update();
})();

// The values of a curve's point, below the panel: under the mouse, tapped or reached by Tab.
for (const panel of document.querySelectorAll(".panels figure")) {
  const output = panel.querySelector("output");
  const tell = (event) => {
    const title = event.target.closest(".point");
    if (title) output.textContent = title.getAttribute("aria-label");
  };
  for (const kind of ["pointerover", "focusin", "click"]) panel.addEventListener(kind, tell);
}
