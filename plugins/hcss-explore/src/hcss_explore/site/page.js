// One page, no library: asks the server for frames as controls change, and draws them.
"use strict";

const $ = (id) => document.getElementById(id);
const page = Math.random().toString(36).slice(2);
const state = { about: null, values: {}, frame: null, band: null, number: 0, pick: null, pixel: null, playing: false };
const wideEnough = matchMedia("(min-width: 701px)");

// ------------------------------------------------------------------ small helpers

function make(tag, properties = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

function digits(value, count = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "none";
  return Math.abs(value) >= 1e-3 || value === 0 ? String(Number(value.toPrecision(count))) : value.toExponential(count - 2);
}

function kelvin(value) {
  return value === null || !Number.isFinite(value) ? "none" : `${value.toFixed(2)} K`;
}

async function post(path, body, signal) {
  const headers = { "Content-Type": "application/json" };
  return fetch(path, { method: "POST", headers, body: JSON.stringify({ page, changes: changes(), ...body }), signal });
}

// ------------------------------------------------------------------ controls

function changes() {
  return { ...state.values };
}

function set(key, value, own) {
  if (JSON.stringify(value) === JSON.stringify(own)) delete state.values[key];
  else state.values[key] = value;
  ask();
}

function errorPlace(key) {
  return make("p", { className: "error", id: `error ${key}`.replace(/[^A-Za-z0-9]+/g, "-") });
}

const places = new Map(); // key -> {error, input}

function control(spec) {
  const box = make("div", { className: "control" });
  const error = errorPlace(spec.key);
  let input;
  if (spec.kind === "many") input = many(spec, box);
  else {
    const id = `key-${spec.key}`.replace(/[^A-Za-z0-9]+/g, "-");
    if (spec.kind === "choice") {
      input = make("select", { id }, ...spec.choices.map((name) => make("option", { value: name, textContent: name })));
      input.value = spec.value;
      input.addEventListener("change", () => set(spec.key, input.value, spec.value));
    } else {
      input = make("input", { id, value: spec.value, placeholder: spec.default, spellcheck: false });
      input.addEventListener("input", () => set(spec.key, input.value.trim(), spec.value));
    }
    const wide = spec.kind === "time" ? " long" : spec.kind === "choice" ? " wide" : "";
    box.append(make("div", { className: `row${wide}` }, make("label", { htmlFor: id, textContent: spec.label }), input));
    if (!wide) box.lastChild.append(make("span", { className: "unit", textContent: spec.unit || "" }));
    if (spec.slider) box.append(slider(spec, input, spec.slider, (text) => Number(text), (number) => String(number)));
    if (spec.kind === "time") box.append(clock(spec, input));
  }
  input.setAttribute("aria-describedby", error.id);
  box.append(error);
  places.set(spec.key, { error, input, spec });
  return box;
}

function slider(spec, input, [min, max, step], read, write) {
  const range = make("input", { type: "range", min, max, step });
  range.setAttribute("aria-label", `${spec.label}, slider`);
  const follow = () => { const value = read(input.value || input.placeholder); if (Number.isFinite(value)) range.value = value; };
  range.addEventListener("input", () => { input.value = write(Number(range.value)); set(spec.key, input.value, spec.value); });
  input.addEventListener("input", follow);
  input.addEventListener("follow", follow);
  follow();
  return range;
}

function clock(spec, input) {
  const minutes = (text) => { const found = /[T ](\d\d):(\d\d)/.exec(text); return found ? 60 * Number(found[1]) + Number(found[2]) : NaN; };
  const write = (number) => {
    const text = [Math.floor(number / 60), number % 60].map((part) => String(part).padStart(2, "0")).join(":");
    return (input.value || spec.value).replace(/([T ])\d\d:\d\d(:\d\d(\.\d+)?)?/, `$1${text}:00`);
  };
  return slider({ ...spec, label: "Time of day" }, input, [0, 1425, 15], minutes, write);
}

function many(spec, box) {
  const list = make("div", { className: "many", role: "group" });
  list.setAttribute("aria-label", spec.label);
  list.tabIndex = -1;
  const chosen = new Set(spec.value.map((value) => JSON.stringify(value)));
  const update = () => {
    const values = spec.choices.map((choice) => choice.value).filter((value) => chosen.has(JSON.stringify(value)));
    set(spec.key, values, spec.choices.map((choice) => choice.value).filter((value) => spec.value.some((own) => JSON.stringify(own) === JSON.stringify(value))));
  };
  for (const choice of spec.choices) {
    const tick = make("input", { type: "checkbox", checked: chosen.has(JSON.stringify(choice.value)) });
    tick.addEventListener("change", () => { chosen[tick.checked ? "add" : "delete"](JSON.stringify(choice.value)); update(); });
    list.append(make("label", {}, tick, ` ${choice.name} `, make("small", { textContent: choice.text })));
  }
  box.append(list);
  return list;
}

function buildControls(groups) {
  const form = $("controls");
  form.addEventListener("submit", (event) => event.preventDefault());
  for (const group of groups) {
    const closed = group.title === "Image and frames";
    form.append(make("details", { open: !closed }, make("summary", { textContent: group.title }), ...group.controls.map(control)));
  }
  const others = make("textarea", { id: "others", rows: 2, placeholder: "slant.shadows = off", spellcheck: false });
  others.addEventListener("input", () => set("others", others.value, ""));
  const error = errorPlace("others");
  others.setAttribute("aria-describedby", error.id);
  places.set("others", { error, input: others, spec: { key: "others" } });
  form.append(make("details", {}, make("summary", { textContent: "Other keys" }),
    make("label", { htmlFor: "others", className: "quiet", textContent: "One a line, as in hcss run --set" }), others, error));
  const reset = make("button", { type: "button", id: "reset", textContent: "Reset all" });
  reset.addEventListener("click", () => location.reload());
  form.append(make("p", {}, reset));
}

function showProblems(problems) {
  for (const { error, input } of places.values()) {
    error.textContent = "";
    input.removeAttribute("aria-invalid");
  }
  for (const problem of problems) {
    const keys = [...places.keys()].filter((key) => problem.field === key || problem.field.startsWith(`${key}.`) || problem.field.startsWith(`${key}[`));
    const key = keys.sort((one, other) => other.length - one.length)[0] ?? "others";
    const place = places.get(key);
    place.error.textContent += `${place.error.textContent ? "; " : ""}${problem.field ? `${problem.field}: ` : ""}${problem.message}`;
    place.input.setAttribute("aria-invalid", "true");
    place.input.closest("details").open = true;
  }
}

// ------------------------------------------------------------------ asking for frames

const STAGES = {
  turn: "waiting for another request, of this page or of another",
  plan: "making a new plan",
  tables: "new plan made; computing its tables",
  frame: "computing the frame",
};
let waiting = null;
let soon = 0;

function say(text, kind = "") {
  $("status").textContent = text;
  $("status").className = kind;
}

function ask() {
  clearTimeout(soon);
  soon = setTimeout(fetchFrame, 40); // the events of one movement
}

async function fetchFrame() {
  waiting?.abort();
  const mine = (waiting = new AbortController());
  const begun = performance.now();
  try {
    const response = await post("frame", { number: state.number, measured: $("measured").checked }, mine.signal);
    if (!response.ok) throw new Error(await response.text());
    const answer = await readFrame(response, begun);
    if (mine !== waiting) return;
    if (answer.dropped) return;
    if (answer.problems) {
      showProblems(answer.problems);
      $("picture").classList.add("stale");
      const count = answer.problems.length;
      say(`${count} problem${count > 1 ? "s" : ""}, beside the control; the image is the last one without`, "bad");
      stopPlaying();
      return;
    }
    showProblems([]);
    state.frame = answer;
    $("picture").classList.remove("stale");
    show(performance.now() - begun);
  } catch (error) {
    if (mine !== waiting || error.name === "AbortError") return;
    stopPlaying();
    $("picture").classList.add("stale");
    say(`no answer: ${error.message || "hcss explore has ended"}`, "bad");
  }
}

async function readFrame(response, begun) {
  const reader = response.body.getReader();
  let bytes = new Uint8Array(0);
  const more = async () => {
    const { done, value } = await reader.read();
    if (done) return false;
    const joined = new Uint8Array(bytes.length + value.length);
    joined.set(bytes);
    joined.set(value, bytes.length);
    bytes = joined;
    return true;
  };
  for (;;) {
    const end = bytes.indexOf(10);
    if (end < 0) {
      if (!(await more())) throw new Error("the answer is not complete");
      continue;
    }
    const line = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end)));
    bytes = bytes.subarray(end + 1);
    if (line.stage) {
      if (line.stage !== "frame") say(`${STAGES[line.stage]} ...`, "busy");
      continue;
    }
    if (!line.about) return line;
    const parts = [bytes];
    let length = bytes.length;
    while (length < line.bytes) {
      const { done, value } = await reader.read();
      if (done) throw new Error("the answer is not complete");
      parts.push(value);
      length += value.length;
    }
    const all = new Uint8Array(length);
    let at = 0;
    for (const part of parts) { all.set(part, at); at += part.length; }
    const { rows, columns, bands } = line.about;
    const pixels = rows * columns;
    const floats = new Float32Array(all.buffer);
    return {
      about: line.about,
      radiance: floats.subarray(0, pixels * bands.length),
      kelvin: floats.subarray(pixels * bands.length, 2 * pixels * bands.length),
      thickness: floats.subarray(2 * pixels * bands.length),
    };
  }
}

// ------------------------------------------------------------------ the image

// Dark blue to sand: one scale from cold to warm, even in lightness.
const MAP = [[16, 24, 48], [32, 58, 92], [58, 96, 120], [100, 132, 138], [150, 165, 150], [203, 195, 158], [246, 232, 190]];

function mapped(share) {
  const at = Math.min(Math.max(share, 0), 1) * (MAP.length - 1);
  const low = Math.min(Math.floor(at), MAP.length - 2);
  return MAP[low].map((value, channel) => value + (at - low) * (MAP[low + 1][channel] - value));
}

const TABLE = new Uint8ClampedArray(256 * 3);
for (let level = 0; level < 256; level++) TABLE.set(mapped(level / 255), 3 * level);

function bandNumber() {
  const names = state.frame.about.bands.map((band) => band.name);
  return Math.max(names.indexOf(state.band), 0);
}

// The band with most to see at first: in the window of 8 to 13 um, then the longest one.
function firstBand(bands) {
  const inWindow = bands.filter((band) => band.lower_um >= 7.9 && band.upper_um <= 14.1);
  return (inWindow[0] ?? bands[bands.length - 1]).name;
}

function plane(values, number = bandNumber()) {
  const pixels = state.frame.about.rows * state.frame.about.columns;
  return values.subarray(number * pixels, (number + 1) * pixels);
}

// Where a value lies between the ends of the colours, 0 to 1: straight, or for "both" bent toward where pixels are, with
// the same weight for clear and for cloudy ones, so that both show structure. It only ever rises.
function scaleOf(values) {
  const [low, high] = limits(values);
  const linear = (value) => (value - low) / (high - low);
  if ($("stretch").value !== "both") return { low, high, share: linear };
  const steps = 400;
  const counts = [new Float64Array(steps), new Float64Array(steps)];
  const { thickness } = state.frame;
  values.forEach((value, pixel) => {
    if (value >= low && value <= high) counts[thickness[pixel] > 0 ? 1 : 0][Math.min(Math.floor(linear(value) * steps), steps - 1)] += 1;
  });
  const present = counts.map((of) => of.reduce((sum, count) => sum + count, 0)).map((sum) => (sum ? 1 / sum : 0));
  const classes = present.filter(Boolean).length || 1;
  const below = new Float64Array(steps + 1);
  for (let step = 0; step < steps; step++) {
    const pixels = counts.reduce((sum, of, kind) => sum + of[step] * present[kind], 0) / classes;
    below[step + 1] = below[step] + 0.5 * pixels + 0.5 / steps;
  }
  return { low, high, share: (value) => {
    const at = Math.min(Math.max(linear(value), 0), 1) * steps;
    const step = Math.min(Math.floor(at), steps - 1);
    return below[step] + (at - step) * (below[step + 1] - below[step]);
  } };
}

function limits(values) {
  const kind = $("stretch").value;
  const { thickness } = state.frame;
  let chosen = values.filter((value, pixel) => Number.isFinite(value) && (kind === "clear" ? thickness[pixel] === 0 : kind === "cloud" ? thickness[pixel] > 0 : true));
  if (!chosen.length) chosen = values.filter(Number.isFinite);
  if (!chosen.length) return [0, 1];
  chosen.sort();
  const cut = kind === "whole" ? 0 : kind === "both" ? 0.002 : 0.01;
  const low = chosen[Math.floor(cut * (chosen.length - 1))];
  const high = chosen[Math.ceil((1 - cut) * (chosen.length - 1))];
  return high > low ? [low, high] : [low - 0.5, low + 0.5];
}

function drawImage() {
  const { rows, columns } = state.frame.about;
  const values = plane(state.frame.kelvin);
  const scale = (state.scale = scaleOf(values));
  const canvas = $("image");
  canvas.width = columns;
  canvas.height = rows;
  const context = canvas.getContext("2d");
  const image = context.createImageData(columns, rows);
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      const value = values[row * columns + column];
      const to = 4 * ((rows - 1 - row) * columns + column); // the first row is the southern one
      const level = Math.min(Math.max(Math.round(255 * scale.share(value)), 0), 255);
      for (let channel = 0; channel < 3; channel++) image.data[to + channel] = Number.isFinite(value) ? TABLE[3 * level + channel] : 128;
      image.data[to + 3] = 255;
    }
  }
  context.putImageData(image, 0, 0);
}

function fitPicture() {
  const { rows, columns } = state.frame?.about ?? { rows: 1, columns: 1 };
  const box = $("picture");
  const room = $("view").clientWidth - 2 * parseFloat(getComputedStyle($("view")).paddingLeft);
  const tallest = Math.max(innerHeight * (wideEnough.matches ? 0.72 : 0.36), 160);
  const width = Math.min(room, (tallest * columns) / rows);
  box.style.width = `${width}px`;
  box.style.height = `${(width * rows) / columns}px`;
  // what has the focus stays below the image where that sticks to the top
  const sticks = getComputedStyle($("view")).position === "sticky";
  document.documentElement.style.scrollPaddingTop = sticks ? `${$("view").offsetHeight + 8}px` : "";
}

// A canvas at the resolution of the screen; returns its context in CSS pixels, and its size.
function fresh(id) {
  const canvas = $(id);
  const { width, height } = canvas.getBoundingClientRect();
  const ratio = devicePixelRatio || 1;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  context.font = "12px system-ui, 'DejaVu Sans', sans-serif";
  return [context, width, height];
}

function outlined(context, draw) {
  context.lineCap = "round";
  context.strokeStyle = context.fillStyle = "#000";
  context.lineWidth = 5;
  draw(true);
  context.strokeStyle = context.fillStyle = "#fff";
  context.lineWidth = 2;
  draw(false);
}

function label(context, text, x, y, wide) {
  context.lineWidth = wide ? 3 : 2;
  if (wide) context.strokeText(text, x, y);
  else context.fillText(text, x, y);
}

function roundLength(metres) {
  const power = 10 ** Math.floor(Math.log10(metres));
  return power * [5, 2, 1].find((factor) => factor * power <= metres);
}

function drawMarks() {
  const [context, width, height] = fresh("marks");
  const about = state.frame.about;
  const perPixel = width / about.columns;
  outlined(context, (wide) => {
    const metres = roundLength((about.pixel_m * about.columns) / 4);
    const length = (metres / about.pixel_m) * perPixel;
    context.beginPath();
    context.moveTo(10, height - 10);
    context.lineTo(10 + length, height - 10);
    context.stroke();
    label(context, metres >= 1000 ? `${metres / 1000} km` : `${metres} m`, 10, height - 16, wide);
    if (about.north_up) compass(context, width - 44, 48, about, wide);
    if (state.pick) {
      const x = (state.pick.column + 0.5) * perPixel;
      const y = height - (state.pick.row + 0.5) * perPixel;
      context.beginPath();
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        context.moveTo(x + 4 * dx, y + 4 * dy);
        context.lineTo(x + 12 * dx, y + 12 * dy);
      }
      context.stroke();
    }
  });
}

// North, and where sun and sensor stand: a disk and a diamond at their bearings, farther out the lower they are.
function compass(context, x, y, about, wide) {
  const radius = 26;
  const bound = context.lineWidth;
  context.lineWidth = wide ? 4 : 1.5;
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.moveTo(x, y - radius);
  context.lineTo(x, y - radius - 4);
  context.stroke();
  context.textAlign = "center";
  label(context, "N", x, y - radius - 7, wide);
  const shape = (sides, px, py, fill) => {
    context.beginPath();
    for (let corner = 0; corner < sides; corner++) context.lineTo(px + 5 * Math.cos((2 * Math.PI * corner) / sides), py + 5 * Math.sin((2 * Math.PI * corner) / sides));
    context.closePath();
    context.lineWidth = wide ? 3 : 1;
    context.stroke();
    if (!wide) { context.fillStyle = fill; context.fill(); context.fillStyle = "#fff"; }
  };
  const named = [[4, "sensor", about.view_azimuth_deg, about.view_zenith_deg, "#4f9cf0"]];
  if (about.sun_zenith_deg < 90) named.push([24, "sun", about.sun_azimuth_deg, about.sun_zenith_deg, "#ffcc33"]);
  named.forEach(([sides, text, bearing, zenith, fill], line) => {
    const angle = (bearing * Math.PI) / 180;
    const out = radius * Math.min(zenith / 90, 1);
    shape(sides, x + Math.sin(angle) * out, y - Math.cos(angle) * out, fill);
    const below = y + radius + 16 + 15 * line;
    context.textAlign = "left";
    label(context, text, x - 14, below, wide);
    shape(sides, x - 24, below - 4, fill);
  });
  context.lineWidth = bound;
  context.textAlign = "left";
}

function ticks(low, high, count) {
  const step = [1, 2, 5, 10].map((factor) => factor * 10 ** Math.floor(Math.log10((high - low) / count))).find((step) => (high - low) / step <= count);
  const found = [];
  for (let value = Math.ceil(low / step) * step; value <= high + 1e-9 * step; value += step) found.push(Number(value.toPrecision(12)));
  return found;
}

function drawScale() {
  const [context, width] = fresh("scale");
  const { low, high, share } = state.scale;
  const room = 28;
  for (let x = 0; x < width - 2 * room; x++) {
    context.fillStyle = `rgb(${mapped(x / (width - 2 * room)).join(",")})`;
    context.fillRect(room + x, 0, 1.5, 14);
  }
  context.fillStyle = colour("ink");
  context.strokeStyle = colour("ink");
  context.textAlign = "center";
  let last = -Infinity;
  const end = width - room;
  const places = ticks(low, high, 24).map((value) => [value, room + share(value) * (end - room)]).filter(([, x]) => x < end - 44);
  for (const [value, x] of [...places, [Number(high.toFixed(2)), end]]) {
    if (x - last < 44) continue;
    last = x;
    context.fillRect(x, 14, 1, 4);
    context.fillText(value, x, 30);
  }
  context.textAlign = "right";
  context.fillText("K", width - 2, 12);
}

// ------------------------------------------------------------------ beside the image

function drawHistogram() {
  const [context, width, height] = fresh("histogram");
  const values = plane(state.frame.kelvin);
  const { thickness } = state.frame;
  const sorted = values.filter(Number.isFinite).sort();
  if (!sorted.length) return;
  let [low, high] = [sorted[Math.floor(0.002 * (sorted.length - 1))], sorted[Math.ceil(0.998 * (sorted.length - 1))]];
  if (high - low < 0.05) [low, high] = [low - 0.5, high + 0.5];
  const count = Math.min(90, Math.floor(width / 4));
  const clear = new Float64Array(count);
  const cloud = new Float64Array(count);
  values.forEach((value, pixel) => {
    const bin = Math.floor(((value - low) / (high - low)) * count);
    if (bin >= 0 && bin < count) (thickness[pixel] > 0 ? cloud : clear)[bin] += 1;
  });
  const most = Math.max(...clear.map((number, bin) => number + cloud[bin]), 1);
  const [top, bottom] = [4, height - 20];
  for (let bin = 0; bin < count; bin++) {
    // square root: few pixels are seen beside many
    const up = (number) => Math.sqrt(number / most) * (bottom - top);
    const [x, step] = [(bin / count) * width, width / count - 0.5];
    context.fillStyle = colour("cloud");
    context.fillRect(x, bottom - up(clear[bin] + cloud[bin]), step, up(clear[bin] + cloud[bin]));
    context.fillStyle = colour("clear");
    context.fillRect(x, bottom - up(clear[bin]), step, clear[bin] ? up(clear[bin]) : 0);
  }
  context.fillStyle = colour("ink");
  context.fillRect(0, bottom, width, 1);
  for (const value of ticks(low, high, 5)) {
    const x = ((value - low) / (high - low)) * width;
    context.textAlign = x < 15 ? "left" : x > width - 15 ? "right" : "center";
    context.fillText(value, x, height - 5);
  }
  const mean = sorted.reduce((sum, value) => sum + value, 0) / sorted.length;
  const deviation = Math.sqrt(sorted.reduce((sum, value) => sum + (value - mean) ** 2, 0) / sorted.length);
  const text = `mean ${kelvin(mean)}, standard deviation ${kelvin(deviation)}, ${kelvin(sorted[0])} to ${kelvin(sorted[sorted.length - 1])}`;
  $("moments").textContent = `(heights by square root); ${text}`;
  $("histogram").setAttribute("aria-label", `Histogram of brightness temperature: ${text}`);
}

function row(cells, kind = "td", name = "") {
  return make("tr", { className: name }, ...cells.map((cell) => {
    const isNumber = typeof cell === "object" && !(cell instanceof Node);
    const element = make(kind, { className: isNumber ? "number" : "" });
    element.append(isNumber ? cell.number : cell);
    return element;
  }));
}

function showPixel() {
  if (!state.pick || !state.frame) return;
  const { about, radiance, thickness } = state.frame;
  const at = state.pick.row * about.columns + state.pick.column;
  const cloud = thickness[at] > 0 ? `cloud ${Math.round(thickness[at])} m thick` : "clear";
  $("picked").textContent = `row ${state.pick.row}, column ${state.pick.column}: ${cloud}`;
  const head = row(["band", { number: "W m-2 sr-1" }, { number: "K" }], "th");
  const rows = about.bands.map((band, number) => row([
    band.name, { number: digits(plane(radiance, number)[at]) }, { number: kelvin(plane(state.frame.kelvin, number)[at]) },
  ], "td", number === bandNumber() ? "shown" : ""));
  $("pixel-bands").replaceChildren(make("thead", {}, head), make("tbody", {}, ...rows));
  drawSpectrum();
}

const PARTS = [
  ["sea_emission", "sea emits", "#2f7ed8"], ["sea_reflected_sun", "sea reflects sun", "#e6a117"],
  ["cloud_emission", "cloud emits", "#8a94a0"], ["cloud_reflected_sun", "cloud reflects sun", "#d9542b"],
  ["path_emission", "air emits", "#3c9d6b"], ["reflected_air_emission", "reflected air", "#8f5fbf"],
  ["path_scattered_sun", "air scatters sun", "#c2498f"],
];

function drawSpectrum() {
  const [context, width, height] = fresh("spectrum");
  const pixel = state.pixel;
  const legend = $("parts");
  if (!pixel) {
    legend.replaceChildren(make("p", { className: "quiet", textContent: state.playing ? "" : "computing the spectrum ..." }));
    return;
  }
  const band = state.frame.about.bands[bandNumber()];
  const inside = pixel.wavelength_um.map((um, index) => [um, index]).sort((one, other) => one[0] - other[0]);
  const names = Object.keys(pixel.parts);
  const known = [...PARTS.filter(([name]) => names.includes(name)), ...names.filter((name) => !PARTS.some(([part]) => part === name)).map((name) => [name, name.replaceAll("_", " "), "#777"])];
  const sum = new Map(inside.map(([, index]) => [index, names.reduce((total, name) => total + pixel.parts[name][index], 0)]));
  const most = Math.max(...sum.values(), 1e-30);
  const [left, right, top, bottom] = [44, width - 8, 20, height - 30];
  const x = (um) => left + ((um - band.lower_um) / (band.upper_um - band.lower_um)) * (right - left);
  const y = (value) => bottom - (value / most) * (bottom - top);
  context.fillStyle = context.strokeStyle = colour("ink");
  context.fillRect(left, bottom, right - left, 1);
  context.textAlign = "center";
  for (const um of ticks(band.lower_um, band.upper_um, 5)) {
    context.fillRect(x(um), bottom, 1, 4);
    context.fillText(um, x(um), bottom + 15);
  }
  context.fillText("um", right - 8, bottom + 27);
  context.textAlign = "right";
  for (const value of ticks(0, most, 4)) {
    context.fillText(digits(value, 2), left - 5, y(value) + 4);
    context.globalAlpha = 0.15;
    context.fillRect(left, y(value), right - left, 1);
    context.globalAlpha = 1;
  }
  context.textAlign = "left";
  context.fillText("W m-2 sr-1 um-1", 2, 12);
  const line = (value, stroke, thick) => {
    context.strokeStyle = stroke;
    context.lineWidth = thick;
    context.beginPath();
    inside.forEach(([um, index], number) => context[number ? "lineTo" : "moveTo"](x(um), y(value(index))));
    context.stroke();
  };
  line((index) => sum.get(index), colour("ink"), 2);
  for (const [name, , stroke] of known) line((index) => pixel.parts[name][index], stroke, 1.5);
  const total = pixel.column_radiance;
  const shares = known.map(([name, text, stroke]) => {
    const key = make("span", { className: "key" });
    key.style.background = stroke;
    const item = make("td", { title: pixel.meaning[name] ?? "" }, key, ` ${text}`);
    return make("tr", {}, item, make("td", { className: "number", textContent: digits(pixel.band_parts[name]) }), make("td", { className: "number", textContent: `${((100 * pixel.band_parts[name]) / total).toFixed(2)} %` }));
  });
  legend.replaceChildren(make("table", {}, make("thead", {}, row([`parts in ${band.name}`, { number: "W m-2 sr-1" }, { number: "share" }], "th")), make("tbody", {}, ...shares)),
    make("p", { className: "quiet", textContent: `The spectrum is that of the pixel's column alone, ${kelvin(pixel.column_kelvin)}, over the scene's sea: without shadows, waves, texture, surfaces, elements, sensor and tables, which the image has.` }));
}

let pixelWaiting = null;
let pixelSoon = 0;

function askPixel() {
  clearTimeout(pixelSoon);
  state.pixel = null;
  showPixel();
  if (state.playing) { pixelWaiting?.abort(); return; }
  pixelSoon = setTimeout(async () => {
    pixelWaiting?.abort();
    const mine = (pixelWaiting = new AbortController());
    try {
      const response = await post("pixel", { number: state.number, band: bandNumber(), ...state.pick }, mine.signal);
      const answer = await response.json();
      if (mine !== pixelWaiting || answer.dropped) return;
      if (answer.problems) { $("picked").textContent += `; no spectrum: ${answer.problems.map((each) => each.message).join("; ")}`; return; }
      state.pixel = answer;
      showPixel();
    } catch (error) {
      if (error.name !== "AbortError") $("picked").textContent += `; no spectrum: ${error.message}`;
    }
  }, 300);
}

function pick(rowNumber, column) {
  const { rows, columns } = state.frame.about;
  state.pick = { row: Math.min(Math.max(rowNumber, 0), rows - 1), column: Math.min(Math.max(column, 0), columns - 1) };
  drawMarks();
  askPixel();
}

// ------------------------------------------------------------------ the whole page

function show(milliseconds) {
  const { about } = state.frame;
  state.number = about.number;
  if (!about.bands.some((band) => band.name === state.band)) state.band = firstBand(about.bands);
  showBands(about.bands);
  fitPicture();
  draw();
  if (!state.pick) state.pick = { row: Math.floor(about.rows / 2), column: Math.floor(about.columns / 2) };
  pick(state.pick.row, state.pick.column);
  $("frame").max = about.count - 1;
  $("frame").value = about.number;
  $("frame").disabled = $("play").disabled = about.count === 1;
  $("frame-text").textContent = `${about.number + 1} of ${about.count}, ${digits(about.time_s)} s`;
  $("measured-label").hidden = !about.has_sensor;
  const work = about.kept ? "plan and tables kept" : `new plan ${about.seconds.plan.toFixed(2)} s, its tables ${about.seconds.tables.toFixed(2)} s`;
  $("cost").textContent = `Processor time: ${work}; frame ${Math.round(1000 * about.seconds.frame)} ms. Frame, band, colours, pixel and sensor on or off keep the plan; every other control makes a new one.`;
  const sun = about.sun_zenith_deg < 90 ? `sun ${(90 - about.sun_zenith_deg).toFixed(1)} deg high` : "night";
  say(`${about.measured ? "as measured" : "at the sensor"}, ${sun}; answered in ${(milliseconds / 1000).toFixed(2)} s`);
  $("toml").textContent = about.toml;
  showOmissions(about);
  showNotes(about);
  for (const filled of about.filled_in) {
    const place = places.get(filled.field);
    if (place?.spec.kind === "text") {
      place.input.placeholder = filled.value;
      place.input.title = `${filled.value}: ${filled.why}`;
      place.input.dispatchEvent(new Event("follow"));
    }
  }
  document.body.dataset.frames = Number(document.body.dataset.frames ?? 0) + 1;
  if (state.playing) setTimeout(() => { if (state.playing) { state.number = (state.number + 1) % about.count; fetchFrame(); } }, 60);
}

function draw() {
  if (!state.frame) return;
  drawImage();
  drawMarks();
  drawScale();
  drawHistogram();
  showPixel();
}

function showBands(bands) {
  const key = JSON.stringify(bands);
  if ($("bands").dataset.of === key) return;
  $("bands").dataset.of = key;
  $("bands").replaceChildren(...bands.map((band) => {
    const input = make("input", { type: "radio", name: "band", value: band.name, checked: band.name === state.band });
    input.addEventListener("change", () => { state.band = band.name; draw(); askPixel(); });
    return make("label", { title: `${digits(band.lower_um)} to ${digits(band.upper_um)} um` }, input, band.name);
  }));
}

function showOmissions(about) {
  const sized = about.omissions.filter((omission) => omission.size !== 0);
  const head = row(["what", { number: "size" }, "key that computes it", "why"], "th");
  $("left-out-about").textContent = `Largest or typical share of a pixel's radiance; the accuracy asked for is ${digits(100 * about.share)} %. ${about.omissions.length - sized.length} more change nothing here.`;
  $("omissions").replaceChildren(make("thead", {}, head), make("tbody", {}, ...sized.map((omission) => {
    const size = omission.size === null ? "equal on average" : `${digits(100 * omission.size, 2)} %`;
    const why = [{ "switched off": "switched off by the scenario", "too dear": "for its time" }[omission.decision] ?? omission.decision, omission.sense, omission.why].filter(Boolean).join("; ");
    return row([omission.what, { number: size }, omission.needs ? make("code", {}, ...omission.needs.split(/(?<=[._])/).flatMap((part) => [part, make("wbr")])) : "none known", why], "td", omission.size > about.share ? "large" : "");
  })));
}

function showNotes(about) {
  const assumed = about.filled_in.map((item) => `${item.field} = ${item.value} (${item.why})`);
  $("notes").replaceChildren(...[...assumed, ...about.notes].map((text) => make("li", { textContent: text })));
}

function stopPlaying() {
  state.playing = false;
  $("play").setAttribute("aria-pressed", "false");
  $("play").textContent = "Play";
}

function listen() {
  const picture = $("picture");
  picture.addEventListener("click", (event) => {
    if (!state.frame) return;
    const box = picture.getBoundingClientRect();
    const { rows, columns } = state.frame.about;
    pick(rows - 1 - Math.floor(((event.clientY - box.top) / box.height) * rows), Math.floor(((event.clientX - box.left) / box.width) * columns));
  });
  picture.addEventListener("keydown", (event) => {
    if (!state.frame || !state.pick) return;
    const step = event.shiftKey ? 10 : 1;
    const moves = { ArrowUp: [step, 0], ArrowDown: [-step, 0], ArrowLeft: [0, -step], ArrowRight: [0, step] };
    const { rows, columns } = state.frame.about;
    if (event.key === "Home") pick(Math.floor(rows / 2), Math.floor(columns / 2));
    else if (event.key in moves) pick(state.pick.row + moves[event.key][0], state.pick.column + moves[event.key][1]);
    else return;
    event.preventDefault();
  });
  $("stretch").addEventListener("change", draw);
  $("measured").addEventListener("change", ask);
  $("frame").addEventListener("input", () => { state.number = Number($("frame").value); ask(); });
  $("play").addEventListener("click", () => {
    if (state.playing) { stopPlaying(); askPixel(); return; }
    state.playing = true;
    $("play").setAttribute("aria-pressed", "true");
    $("play").textContent = "Pause";
    state.number = (state.number + 1) % state.frame.about.count;
    fetchFrame();
  });
  $("save").addEventListener("submit", async (event) => {
    event.preventDefault();
    const answer = await (await post("save", { name: $("name").value, replace: $("replace").checked })).json();
    $("saved").className = answer.path ? "quiet" : "error";
    $("saved").textContent = answer.path ? `written: ${answer.path}; next: hcss run ${/\s/.test(answer.path) ? `"${answer.path}"` : answer.path}` : answer.problems.map((each) => `${each.field ? `${each.field}: ` : ""}${each.message}`).join("; ");
  });
  $("run").addEventListener("click", run);
  $("stop").addEventListener("click", () => post("run", { stop: true }));
  new ResizeObserver(() => { if (state.frame) { fitPicture(); draw(); } }).observe($("view"));
  addEventListener("resize", () => { if (state.frame) { fitPicture(); draw(); } });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
}

async function run() {
  $("run").disabled = true;
  $("stop").hidden = false;
  const begun = performance.now();
  const clockwork = setInterval(() => { $("run-state").textContent = `running for ${Math.round((performance.now() - begun) / 1000)} s ...`; }, 500);
  try {
    const answer = await (await post("run", {})).json();
    if (answer.problems) $("run-state").textContent = answer.problems.map((each) => `${each.field}: ${each.message}`).join("; ");
    else if (answer.code === null) $("run-state").textContent = "stopped";
    else {
      $("run-state").textContent = `hcss run, exit code ${answer.code}, in ${Math.round((performance.now() - begun) / 1000)} s; the cube is deleted: save the scenario and run it to have one`;
      $("said").hidden = false;
      $("said").textContent = answer.text;
    }
  } catch (error) {
    $("run-state").textContent = `no answer: ${error.message}`;
  } finally {
    clearInterval(clockwork);
    $("run").disabled = false;
    $("stop").hidden = true;
  }
}

async function begin() {
  const response = await fetch("about");
  if (!response.ok) { say(await response.text(), "bad"); return; }
  state.about = await response.json();
  document.title = `${state.about.title} - hcss explore`;
  $("title").textContent = state.about.title;
  buildControls(state.about.controls);
  listen();
  fetchFrame();
}

begin();
