// The widget of `emitree.view`: draws the state that Python sends, and sends what the user asks for.
// Its traits are described in `_view_widget.py`. The functions of `_view_drawing.js`, which comes before it
// in the same module, draw.

const LEAST_PAUSE_MS = 120; // between two messages while the pointer moves
const STEP = 1 / 36; // of the image, for each key that turns the camera
const WIDGET = "emitree._view_widget.View";
const VIEW_TYPE = "application/vnd.jupyter.widget-view+json";
const STATE_TYPE = "application/vnd.jupyter.widget-state+json";

// JupyterLab saves no widgets unless it is set to. The states of the views that are in the notebook are
// added to what it saves; other notebooks have no such context.
const saveWithNotebook = (model) => {
  const manager = model.widget_manager;
  const context = manager?.context;
  if (!context?.saveState?.connect || !context.model?.setMetadata || !manager.get_state_sync) return () => {};
  const save = (_, phase) => {
    if (phase !== "started") return;
    const outputs = (context.model.toJSON().cells ?? []).flatMap((cell) => cell.outputs ?? []);
    const shown = new Set(outputs.map((output) => output.data?.[VIEW_TYPE]?.model_id));
    const metadata = context.model.getMetadata("widgets") ?? {};
    const saved = metadata[STATE_TYPE]?.state ?? {};
    const models = { ...saved, ...manager.get_state_sync({ drop_defaults: true }).state };
    const isOurs = ([, { state }]) => state._anywidget_id === WIDGET;
    const ours = Object.entries(models).filter(isOurs);
    const kept = Object.fromEntries(Object.entries(saved).filter((entry) => !isOurs(entry)));
    for (const [id, entry] of ours) {
      if (!shown.has(id)) continue;
      kept[id] = entry;
      const layout = String(entry.state.layout).replace("IPY_MODEL_", "");
      if (models[layout]) kept[layout] = models[layout];
    }
    const state = { version_major: 2, version_minor: 0, state: kept };
    context.model.setMetadata("widgets", { ...metadata, [STATE_TYPE]: state });
  };
  context.saveState.connect(save);
  return () => context.saveState.disconnect(save);
};

const HELP = [
  [["←", "→", "↑", "↓"], "move the cursor by a pixel"],
  [["Shift", "←", "→", "↑", "↓"], "turn the camera, as dragging the image does"],
  [["Home"], "go to the pixel with the largest value"],
  [["L"], "linear or logarithmic colours"],
  [["E"], "error or evaluations beside the image"],
  [["Esc"], "stop the rendering"],
];

const render = ({ model, el }) => {
  const image = makePanel(shades(VIRIDIS));
  const beside = makePanel(shades(MAGMA));
  const svg = drawn("svg", { role: "img" });
  const spectrumTitle = node("figcaption");
  const spectrum = node("figure", { style: `width:${SMALL_SIDE_PX}px` }, spectrumTitle, svg);
  const readout = node("output", { "aria-live": "polite" });
  const message = node("p", { class: "message", role: "status" });
  const option = (value, text) => node("option", { value }, text);
  const stretch = node("select", {}, option("linear", "linear"), option("log", "logarithmic"));
  const map = node("select", {}, option("error", "error"), option("evaluations", "evaluations"));
  const stop = node("button", { type: "button" }, "Stop");
  const resume = node("button", { type: "button" }, "Go on");
  const goal = node("input", { type: "text", inputmode: "decimal" });
  const goalName = node("span");
  const goalLabel = node("label", {}, goalName, goal);
  const keys = HELP.map(([names, text]) =>
    node("div", {}, ...names.flatMap((name) => [node("kbd", {}, name), " "]), text));
  const help = node("details", {}, node("summary", {}, "Keys, with the focus on the image"), ...keys);
  const panels = node("div", { class: "panels" }, image.figure, beside.figure, spectrum);
  const root = node("div", { class: "emitree-view", role: "group", "aria-label": "emitree: image with its error" }, panels, readout, message,
  node("div", { class: "controls" }, stop, goalLabel, resume,
    node("label", {}, "Colours", stretch), node("label", {}, "Beside", map)), help);
  // The picture for readers without widgets, which is the next output, is not shown here.
  const still = `.emitree-still-${model.get("still")}`;
  root.append(node("style", {}, `${still}, .jp-OutputArea-child:has(${still}) { display: none; }`));
  el.append(root);
  // Keys are those of the view, and no shortcuts of JupyterLab, which versions before 4.1 find otherwise.
  root.addEventListener("keydown", (event) => {
    if (!event.ctrlKey && !event.metaKey && !event.altKey) event.stopPropagation();
  });
  for (const focusable of root.querySelectorAll("button, input, select, summary, .pixels"))
    focusable.setAttribute("data-lm-suppress-shortcuts", "true");
  image.pixels.setAttribute("tabindex", "0");
  image.pixels.setAttribute("role", "application");
  image.pixels.setAttribute("aria-label", "Image: arrows move the cursor, with Shift they turn the camera");

  let picture = null;
  let hasKernel = false;
  let timer = null;
  const status = () => model.get("status");
  const isLog = () => model.get("stretch") === "log";

  // Column and row of the pixel at the cursor; the cursor is at fractions of the width and the height.
  const pixelAt = (fractions) => {
    const inside = (share, count) => Math.min(count - 1, Math.max(0, Math.floor(share * count)));
    return [inside(fractions[0], picture.width), inside(fractions[1], picture.height)];
  };
  const showCursor = () => {
    const cursor = model.get("cursor");
    if (!picture || cursor.length !== 2) return;
    const [column, row] = pixelAt(cursor);
    for (const panel of [image, beside]) panel.mark([column, row], picture);
    const at = row * picture.width + column;
    const coordinate = (axis, index, count) => {
      const { name, unit, ends } = picture.axes[axis];
      const value = count > 1 ? ends[0] + ((ends[1] - ends[0]) * index) / (count - 1) : ends[0];
      return `${name.split(" on ")[0]} ${withUnit(number(value), unit)}`;
    };
    const place = picture.axes
      ? [coordinate(0, column, picture.width), coordinate(1, row, picture.height)]
      : [`column ${column}`, `row ${row}`];
    const parts = [`${place.join(", ")}: `];
    if (picture.block > 1) parts.push(`mean of ${picture.block} × ${picture.block} pixels `);
    const value = picture.image[at];
    const error = picture.error && Number.isFinite(value) ? ` ± ${number(picture.error[at], 2)}` : "";
    parts.push(withUnit(`${number(value)}${error}`, picture.unit));
    if (picture.evaluations && Number.isFinite(value))
      parts.push(`, ${number(picture.evaluations[at], 2)} evaluations`);
    readout.textContent = parts.join("");
  };

  const showPicture = () => {
    picture = decode(model.get("picture"));
    panels.hidden = readout.hidden = !picture;
    if (!picture) return;
    const bracketed = picture.unit ? ` [${picture.unit}]` : "";
    const capital = picture.quantity[0].toUpperCase() + picture.quantity.slice(1);
    image.show(`${capital}${bracketed}`, picture.image, picture, isLog(), picture.unit);
    if (model.get("beside") === "error")
      beside.show(`Estimated error${bracketed}`, picture.error, picture, isLog(), picture.unit);
    else beside.show("Evaluations per pixel", picture.evaluations, picture, isLog(), "");
    showCursor();
    showSpectrum();
  };

  const showSpectrum = () => {
    const found = model.get("spectrum");
    spectrum.hidden = !picture?.bins;
    spectrumTitle.textContent = found.values
      ? `Spectrum${found.unit ? ` [${found.unit}]` : ""}` : "Spectrum: choose a pixel";
    svg.toggleAttribute("hidden", !found.values);
    if (found.values) drawSpectrum(svg, found, isLog());
  };

  const showStatus = () => {
    const { phase, message: text, goal: aim, can_resume: canResume } = status();
    message.textContent = text ?? "";
    message.classList.toggle("is-failed", phase === "failed");
    root.setAttribute("aria-busy", String(phase === "running"));
    for (const control of [stop, resume, goalLabel]) control.hidden = !canResume || !hasKernel;
    const hadFocus = document.activeElement === stop;
    stop.disabled = phase !== "running";
    if (hadFocus && stop.disabled) resume.focus();
    goalLabel.hidden ||= !aim;
    const suggested = aim ? `${Number((phase === "done" ? aim.value / 10 : aim.value).toPrecision(3))}` : "";
    if (goal.dataset.suggested !== suggested) {
      goal.dataset.suggested = goal.value = suggested;
      goalName.textContent = aim?.name ?? "";
    }
    stretch.value = model.get("stretch");
    map.value = model.get("beside");
  };

  const save = () => {
    timer ??= setTimeout(() => { timer = null; model.save_changes(); }, LEAST_PAUSE_MS);
  };
  const choose = (name, value) => { model.set(name, value); save(); };
  const moveTo = (x, y) => choose("cursor", [x, y].map((share) => Math.min(1, Math.max(0, share))));
  const moveToPixel = (column, row) => moveTo((column + 0.5) / picture.width, (row + 0.5) / picture.height);
  const placeOf = (event) => {
    const box = image.canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, 1 - (event.clientY - box.top) / box.height];
  };
  const goOn = () => {
    const aim = status().goal;
    const value = Number(goal.value);
    if (aim && !(value > 0)) { message.textContent = `${aim.name} is ${goal.value}: expected a number above 0`; return; }
    model.send({ kind: "resume", options: aim ? { [aim.name]: value } : {} });
  };

  // Drags since the last message, as fractions of the image.
  let drag = null;
  let sent = 0;
  const turn = (isFinal) => {
    if (!isFinal && (performance.now() - sent < LEAST_PAUSE_MS || !(drag.right || drag.up))) return;
    model.send({ kind: "turn", right: drag.right, up: drag.up, is_final: isFinal });
    Object.assign(drag, { right: 0, up: 0 });
    sent = performance.now();
  };
  image.pixels.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || !picture) return;
    event.preventDefault();
    image.pixels.focus();
    image.pixels.setPointerCapture(event.pointerId);
    moveTo(...placeOf(event));
    drag = { x: event.clientX, y: event.clientY, right: 0, up: 0, moved: false };
  });
  image.pixels.addEventListener("pointermove", (event) => {
    if (!picture) return;
    if (!drag) { moveTo(...placeOf(event)); return; }
    if (!status().can_turn || !hasKernel) return;
    const [dx, dy] = [event.clientX - drag.x, event.clientY - drag.y];
    drag.moved ||= Math.hypot(dx, dy) > 4;
    if (!drag.moved) return;
    panels.classList.add("is-turned");
    const box = image.canvas.getBoundingClientRect();
    drag.right += dx / box.width;
    drag.up -= dy / box.height;
    Object.assign(drag, { x: event.clientX, y: event.clientY });
    turn(false);
  });
  const release = () => {
    if (drag?.moved) turn(true);
    drag = null;
    panels.classList.remove("is-turned");
  };
  image.pixels.addEventListener("pointerup", release);
  image.pixels.addEventListener("pointercancel", release);

  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  image.pixels.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !picture) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const [column, row] = model.get("cursor").length ? pixelAt(model.get("cursor")) : [-1, 0];
    if (arrows[key] && event.shiftKey) {
      const [right, up] = arrows[key].map((step) => step * STEP);
      if (status().can_turn) model.send({ kind: "turn", right, up, is_final: true });
    } else if (arrows[key]) moveToPixel(column + arrows[key][0], row + arrows[key][1]);
    else if (key === "Home") {
      const best = picture.image.reduce((at, value, i, all) => (value > (all[at] || -Infinity) ? i : at), 0);
      moveToPixel(best % picture.width, Math.floor(best / picture.width));
    } else if (key === "l") choose("stretch", isLog() ? "linear" : "log");
    else if (key === "e") choose("beside", model.get("beside") === "error" ? "evaluations" : "error");
    else if (key === "Escape") model.send({ kind: "stop" });
    else return;
    event.preventDefault();
  });
  stop.addEventListener("click", () => model.send({ kind: "stop" }));
  resume.addEventListener("click", goOn);
  goal.addEventListener("keydown", (event) => { if (event.key === "Enter") goOn(); });
  stretch.addEventListener("change", () => choose("stretch", stretch.value));
  map.addEventListener("change", () => choose("beside", map.value));

  const handlers = {
    "change:picture": showPicture,
    "change:status": showStatus,
    "change:cursor": showCursor,
    "change:spectrum": showSpectrum,
    "change:stretch": () => { showPicture(); showStatus(); },
    "change:beside": () => { showPicture(); showStatus(); },
    // Without an answer there is no kernel: the picture is that of a saved notebook.
    "msg:custom": (content) => { if (content.kind === "hello") { hasKernel = true; showStatus(); } },
  };
  for (const [name, handler] of Object.entries(handlers)) model.on(name, handler);
  showPicture();
  showStatus();
  model.send({ kind: "hello" });
  return () => {
    clearTimeout(timer);
    for (const [name, handler] of Object.entries(handlers)) model.off(name, handler);
  };
};

export default { initialize: ({ model }) => saveWithNotebook(model), render };
