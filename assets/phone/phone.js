"use strict";
// The phone's side of `vrlf serve`: shows frames pixel for pixel or says why not, sends the head's
// turning and keys. Wire format: vrlf/app/serve/wire.py.

const HEAD_BYTES = 32;
const FADE_AFTER_MS = 700;
const PROMPT_MS = 3500;
const CARD_MM = 85.6;
const LONG_TAP_MS = 600;
const RETRY_MS = 250, FULL_RETRY_MS = 3000;
// Silence of the server: an answer is due twice a second, unless a frame is on its way.
const BEAT_MS = 500, SILENT_MS = 3000, GIVEN_UP_MS = 8000;

const at = (id) => document.getElementById(id);
const canvas = at("picture");
const context = canvas.getContext("2d", { alpha: false });

const state = {
  socket: null, rig: null, fits: false, isOpen: false, isPattern: false, lastFrameMs: 0,
  shown: 0, newest: 0, decoding: Promise.resolve(), pending: null, turn: null, turnSentMs: 0,
  lock: null, stats: [], isHeld: false, begun: false, boxPx: null, viewPx: null, image: null,
  isFull: false, heardMs: 0,
};

// What does not fit, in plain words; nothing where all does.
function problems(found) {
  const said = [];
  const { rig, screenPx, ratio, zoom, isLandscape, boxPx, viewPx } = found;
  if (!rig) return said;
  const long = Math.max(rig.width, rig.height), short = Math.min(rig.width, rig.height);
  if (rig.width < rig.height) {
    said.push(`The rig's panel stands upright (${rig.width} x ${rig.height} pixels): exchange its width_px and height_px.`);
  }
  if (!isLandscape) said.push("The phone stands upright. Turn it on its side.");
  if (Math.abs(zoom - 1) > 1e-3) {
    said.push(`The page is zoomed to ${Math.round(100 * zoom)} %. Pinch until it is 100 %.`);
  }
  // Browsers tell a screen in whole pixels of the page, rounded or upward.
  if (Math.abs(Math.max(...screenPx) - long) >= ratio || Math.abs(Math.min(...screenPx) - short) >= ratio) {
    said.push(`The rig's panel has ${long} x ${short} pixels, this screen ${Math.max(...screenPx)} x ` +
      `${Math.min(...screenPx)}. Give vrlf serve a rig with this phone's panel, or measure this ` +
      "screen below and let it write one.");
  } else if (boxPx && (boxPx[0] !== rig.width || boxPx[1] !== rig.height)) {
    said.push(`A picture of ${rig.width} x ${rig.height} pixels would fill ${boxPx[0]} x ${boxPx[1]} ` +
      `of the screen's (pixel ratio ${ratio}). Set the browser's zoom and the phone's display size ` +
      "back to normal.");
  } else if (viewPx && isLandscape && (viewPx[0] !== rig.width || viewPx[1] !== rig.height)) {
    said.push(`The page covers ${viewPx[0]} x ${viewPx[1]} of the screen's pixels, the picture needs ` +
      `${rig.width} x ${rig.height}. Tap Begin for fullscreen. On an iPhone add the page to the Home ` +
      "Screen and open it from there.");
  }
  return said;
}

function report() {
  const ratio = window.devicePixelRatio;
  return {
    rig: state.rig, ratio,
    screenPx: [Math.round(screen.width * ratio), Math.round(screen.height * ratio)],
    zoom: window.visualViewport ? window.visualViewport.scale : 1,
    isLandscape: window.innerWidth >= window.innerHeight,
    boxPx: state.boxPx,
    // Before it begins the page need not fill the screen.
    viewPx: state.begun ? viewPx() : null,
  };
}

// The screen's pixels that the page covers: exact where the browser tells, else reckoned.
function viewPx() {
  if (state.viewPx) return state.viewPx;
  const box = at("grey").getBoundingClientRect(), ratio = window.devicePixelRatio;
  return [Math.round(box.width * ratio), Math.round(box.height * ratio)];
}

// The canvas's size in the page's pixels, so that each of its pixels is one of the screen's.
function place() {
  if (!state.rig) return;
  const { width, height } = state.rig;
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
    state.image = null;
  }
  canvas.style.width = `${width / window.devicePixelRatio}px`;
  canvas.style.height = `${height / window.devicePixelRatio}px`;
}

function check() {
  place();
  const said = problems(report());
  at("problems").replaceChildren(...said.map((text) => {
    const item = document.createElement("li");
    item.textContent = text;
    return item;
  }));
  const isRight = state.isOpen && state.rig && state.fits && said.length === 0;
  const isScreenRight = problems({ ...report(), isLandscape: true, viewPx: null }).length === 0;
  at("begin").disabled = !(state.rig && isScreenRight);
  at("pattern").disabled = !state.rig;
  at("state").textContent = state.isFull ? "As many phones as there is room for are on already." :
    !state.isOpen ? "Connecting." :
    said.length ? "Not shown, because:" : "This screen fits the rig.";
  // A wrong picture is worse than none.
  canvas.hidden = !((isRight && state.begun) || state.isPattern);
  at("door").hidden = (isRight && state.begun) || state.isPattern;
  if (!isRight && state.begun && !state.isPattern) at("door").hidden = false;
  return isRight;
}

// Frames

// Four strips, packed each by itself; before them their lengths.
const STRIPS = 4;
async function unpacked(bytes) {
  const lengths = new DataView(bytes.buffer, bytes.byteOffset, 4 * STRIPS);
  let start = 4 * STRIPS;
  const strips = [];
  for (let k = 0; k < STRIPS; k++) {
    const length = lengths.getUint32(4 * k, true);
    strips.push(inflated(bytes.subarray(start, start + length)));
    start += length;
  }
  const parts = await Promise.all(strips);
  const whole = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  parts.reduce((place, part) => { whole.set(part, place); return place + part.length; }, 0);
  return whole;
}

async function inflated(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function rgba(rgb, width, height) {
  const out = new Uint32Array(width * height);
  for (let i = 0, k = 0; i < out.length; i++, k += 3) {
    out[i] = 0xff000000 | (rgb[k + 2] << 16) | (rgb[k + 1] << 8) | rgb[k];
  }
  return new ImageData(new Uint8ClampedArray(out.buffer), width, height);
}

function frameOf(buffer) {
  const view = new DataView(buffer);
  if (view.getUint8(0) !== 0x56 || view.getUint8(1) !== 0x46 || view.getUint8(2) !== 1) {
    throw new Error("no frame of ours");
  }
  return {
    encoding: view.getUint8(3), number: view.getUint32(4, true),
    width: view.getUint16(8, true), height: view.getUint16(10, true),
    sensorMs: view.getFloat64(12, true), waitedMs: view.getFloat32(20, true),
    drawnMs: view.getFloat32(24, true), encodedMs: view.getFloat32(28, true),
    cameMs: performance.now(), data: new Uint8Array(buffer, HEAD_BYTES),
  };
}

async function take(buffer) {
  const frame = frameOf(buffer);
  const rgb = frame.encoding === 1 ? await unpacked(frame.data) : frame.data;
  if (rgb.length !== 3 * frame.width * frame.height) throw new Error("a frame of another size");
  if (!state.rig || frame.width !== state.rig.width || frame.height !== state.rig.height) return;
  frame.image = rgba(rgb, frame.width, frame.height);
  const isIdle = !state.pending;
  if (!isIdle) tell(state.pending, null);
  state.pending = frame;
  if (isIdle) document.hidden ? show() : requestAnimationFrame(show);
}

// Both eyes at once: one picture, put between two refreshes.
function show() {
  const frame = state.pending;
  state.pending = null;
  if (!frame) return;
  state.image = frame.image;
  if (!state.isPattern) context.putImageData(frame.image, 0, 0);
  state.shown += 1;
  state.newest = frame.number;
  state.lastFrameMs = performance.now();
  const hasTurn = !Number.isNaN(frame.sensorMs);
  // What was put in this callback is on the screen a refresh later.
  requestAnimationFrame((nowMs) => {
    const photonMs = hasTurn ? nowMs - frame.sensorMs : NaN;
    // Otherwise the turn was another page's, by another clock, or of before a pause.
    tell(frame, photonMs >= 0 && photonMs < 2000 ? photonMs : null);
  });
  if (document.hidden) tell(frame, null);
}

function tell(frame, photonMs) {
  if (frame.isTold) return;
  frame.isTold = true;
  send({ t: "shown", number: frame.number, photon: photonMs });
  if (photonMs === null) return;
  state.stats.push({
    photon: photonMs, waited: frame.waitedMs, drawn: frame.drawnMs, encoded: frame.encodedMs,
    decoded: state.lastFrameMs - frame.cameMs,
  });
  if (state.stats.length > 30) state.stats.shift();
  sayLatency();
}

function sayLatency() {
  const count = state.stats.length;
  const mean = (key) => state.stats.reduce((sum, each) => sum + each[key], 0) / count;
  const rest = mean("photon") - mean("waited") - mean("drawn") - mean("encoded") - mean("decoded");
  const parts = [["waiting", mean("waited")], ["drawing", mean("drawn")], ["packing", mean("encoded")],
    ["unpacking", mean("decoded")], ["link, screen", rest]];
  state.latency = `motion to photon ${mean("photon").toFixed(0)} ms\n` +
    parts.map(([name, ms]) => `${name} ${ms.toFixed(0)}`).join("\n");
  showLatency();
}

// Before each eye, as large as other words: it is to be read in the headset.
function showLatency() {
  for (const id of ["latency-left", "latency-right"]) {
    at(id).textContent = state.hasLatency ? state.latency : "";
    at(id).hidden = !(state.hasLatency && state.latency);
  }
}

// The socket

function send(message) {
  const socket = state.socket;
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

let toldScreen = "";
const screenNow = () => `${screen.width} ${screen.height} ${window.devicePixelRatio}`;
function hello() {
  toldScreen = screenNow();
  send({ t: "hello", width: screen.width, height: screen.height, ratio: window.devicePixelRatio,
    inflates: "DecompressionStream" in window });
}

function connect() {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  const socket = new WebSocket(`${scheme}//${location.host}${location.pathname}live`);
  socket.binaryType = "arraybuffer";
  state.socket = socket;
  state.heardMs = performance.now();
  socket.onopen = () => { state.isOpen = true; state.isHeld = state.isFull = false; hello(); check(); };
  socket.onmessage = (event) => {
    if (state.socket !== socket) return;
    state.heardMs = performance.now();
    if (typeof event.data !== "string") {
      // One after the other: unpacking takes its time, and frames keep their order.
      state.decoding = state.decoding.then(() => take(event.data)).catch(() => socket.close());
      return;
    }
    heard(JSON.parse(event.data));
  };
  socket.onclose = (event) => {
    if (state.socket !== socket) return;
    state.isOpen = false;
    state.isFull = event.code === 1013;
    setTimeout(connect, state.isFull ? FULL_RETRY_MS : RETRY_MS);
  };
}

// A link may die without a word; a browser then waits for minutes.
function giveUp() {
  const socket = state.socket;
  state.socket = null;
  state.isOpen = false;
  socket.close();
  connect();
}

const silentMs = () => performance.now() - state.heardMs;
const isTaken = () => state.socket && state.socket.readyState <= WebSocket.OPEN;
setInterval(() => {
  if (isTaken() && !document.hidden && silentMs() > GIVEN_UP_MS) giveUp();
  else send({ t: "beat" });
  // Not every browser tells of another ratio.
  if (state.isOpen && toldScreen !== screenNow()) { hello(); check(); }
}, BEAT_MS);
// Back on a network, or awake: what was silent meanwhile is not waited for.
const back = () => { if (isTaken() && !document.hidden && silentMs() > 2 * BEAT_MS) giveUp(); };
window.addEventListener("online", back);

function heard(message) {
  if (message.t === "rig") {
    state.rig = message;
    state.fits = message.fits;
    place();
    check();
  } else if (message.t === "say") {
    // Before each lens: elsewhere the eyes cannot bring the words together.
    if (message.axes) placeWords(message.axes);
    prompt(message.left, message.right);
    state.hasLatency = Boolean(message.latency);
    showLatency();
  } else if (message.t === "held") {
    state.isHeld = true;
  } else if (message.t === "going") {
    state.isHeld = false;
  }
}

// Words stand about each lens's axis, as wide as the eye's half of the panel leaves room for.
function placeWords(axes) {
  for (const [i, side] of ["left", "right"].entries()) {
    const fromOuterEdge = i === 0 ? axes[0] : 1 - axes[1];
    const room = 2 * Math.min(fromOuterEdge, 0.5 - fromOuterEdge) - 0.01;
    for (const what of ["prompt", "latency"]) {
      at(`${what}-${side}`).style.left = `${100 * axes[i]}%`;
      at(`${what}-${side}`).style.width = `${100 * Math.max(room, 0.2)}%`;
    }
  }
}

let promptTimer = 0;
function prompt(left, right) {
  for (const [id, text] of [["prompt-left", left], ["prompt-right", right]]) {
    at(id).textContent = text || "";
    at(id).classList.toggle("on", Boolean(text));
  }
  clearTimeout(promptTimer);
  promptTimer = setTimeout(() => {
    for (const id of ["prompt-left", "prompt-right"]) at(id).classList.remove("on");
  }, PROMPT_MS);
}

// A fault holds the last picture, then gives way to grey slowly: nothing flashes.
let brokenSinceMs = null;
let ratioSeen = window.devicePixelRatio;
setInterval(() => {
  // Another ratio of pixels alone is no event that every browser gives.
  if (ratioSeen !== window.devicePixelRatio) {
    ratioSeen = window.devicePixelRatio;
    hello();
    check();
  }
  const isBroken = !state.isOpen || state.isHeld || (silentMs() > SILENT_MS && !document.hidden);
  if (!isBroken) brokenSinceMs = null;
  else if (brokenSinceMs === null) brokenSinceMs = performance.now();
  const isLong = brokenSinceMs !== null && performance.now() - brokenSinceMs > FADE_AFTER_MS;
  at("grey").classList.toggle("on", isLong && state.begun);
}, 100);

// The head

window.addEventListener("deviceorientation", (event) => {
  if (event.alpha === null || event.beta === null || event.gamma === null) return;
  const nowMs = performance.now();
  if (nowMs - state.turnSentMs < 8) return;
  // Turns that wait for the link are old when they come.
  if (state.socket && state.socket.bufferedAmount > 2048) return;
  state.turnSentMs = nowMs;
  // iPhones before iOS 16.4 know the older name alone.
  const angle = screen.orientation ? screen.orientation.angle : window.orientation || 0;
  // An event's time stamp is by the same clock as performance.now().
  send({ t: "turn", alpha: event.alpha, beta: event.beta, gamma: event.gamma, screen: angle,
    at: event.timeStamp });
});

// Keys, pads, taps: names as in the preview's table.

const NAMED = { ArrowUp: "up", ArrowDown: "down", ArrowLeft: "left", ArrowRight: "right",
  Enter: "enter", NumpadEnter: "enter", Backspace: "backspace", Tab: "tab", Space: "space",
  PageUp: "pageup", PageDown: "pagedown", Home: "home", Escape: "escape", BracketLeft: "[",
  BracketRight: "]", Comma: ",", Period: ".", Minus: "-", Equal: "=" };

function chordOf(event) {
  let name = NAMED[event.code];
  if (!name && /^Key[A-Z]$/.test(event.code)) name = event.code.slice(3).toLowerCase();
  if (!name && /^(Digit|Numpad)[0-9]$/.test(event.code)) name = event.code.slice(-1);
  if (!name && /^F([1-9]|1[0-2])$/.test(event.code)) name = event.code.toLowerCase();
  if (!name) return null;
  return [...(event.ctrlKey ? ["ctrl"] : []), ...(event.shiftKey ? ["shift"] : []), name].join("+");
}

window.addEventListener("keydown", (event) => {
  if (event.target.tagName === "INPUT" || (event.target.tagName === "BUTTON" && event.code === "Enter")) return;
  const chord = chordOf(event);
  if (!chord) return;
  event.preventDefault();
  send({ t: "key", chord });
});

// Of the standard pad: sphere up, down; cylinder; axis; which eye; method; undo; fringes; ahead.
const PAD = { 12: "up", 13: "down", 14: "left", 15: "right", 4: "[", 5: "]", 2: "1", 1: "2", 0: "3",
  3: "m", 8: "ctrl+z", 9: "g", 11: "h" };
const held = new Set();
function pads() {
  for (const pad of navigator.getGamepads ? navigator.getGamepads() : []) {
    if (!pad) continue;
    for (const [index, chord] of Object.entries(PAD)) {
      const id = `${pad.index}:${index}`;
      const isDown = Boolean(pad.buttons[index] && pad.buttons[index].pressed);
      if (isDown && !held.has(id)) send({ t: "key", chord });
      isDown ? held.add(id) : held.delete(id);
    }
  }
}
setInterval(pads, 16);

// The headset's one button: a tap does what a long tap has chosen, keys of the same table.
const BUTTON = [["look straight ahead", "h"], ["left eye", "1"], ["right eye", "2"], ["both eyes", "3"],
  ["sphere less", "down"], ["sphere more", "up"], ["cylinder less", "left"], ["cylinder more", "right"],
  ["axis back", "["], ["axis on", "]"], ["undo", "ctrl+z"], ["next prefilter", "m"],
  ["next alignment screen", "g"], ["save the rig", "ctrl+s"], ["latency", "t"], ["back to the page", null]];
let chosen = 0;

let downMs = 0;
canvas.addEventListener("pointerdown", () => { downMs = performance.now(); });
canvas.addEventListener("pointerup", () => {
  if (state.isPattern) { endPattern(); return; }
  const isLong = performance.now() - downMs >= LONG_TAP_MS;
  if (isLong) chosen = (chosen + 1) % BUTTON.length;
  const [words, chord] = BUTTON[chosen];
  if (isLong) { prompt(`tap: ${words}`, `tap: ${words}`); return; }
  if (chord) { send({ t: "key", chord }); return; }
  state.begun = false;
  chosen = 0;
  check();
});

// Beginning: what needs a touch

// What a browser may refuse, or never answer, is no reason to show nothing.
const tried = (promise) => Promise.race([
  Promise.resolve(promise).catch(() => null), new Promise((done) => setTimeout(done, 1500)),
]);

// iPhones have no fullscreen for pages.
async function fillScreen() {
  const root = document.documentElement;
  const ask = root.requestFullscreen || root.webkitRequestFullscreen;
  if (ask && !document.fullscreenElement) await tried(ask.call(root, { navigationUI: "hide" }));
}

async function begin() {
  // iPhones give motion only when asked within a touch.
  if (window.DeviceOrientationEvent && DeviceOrientationEvent.requestPermission) {
    await tried(DeviceOrientationEvent.requestPermission());
  }
  await fillScreen();
  if (screen.orientation && screen.orientation.lock) await tried(screen.orientation.lock("landscape"));
  await keepAwake();
  state.begun = true;
  check();
}

async function keepAwake() {
  if (!navigator.wakeLock) return;
  state.lock = await tried(navigator.wakeLock.request("screen"));
}

document.addEventListener("visibilitychange", () => {
  back();
  if (document.hidden || !state.begun) return;
  keepAwake();
  hello();
});

// Single pixels: grey and even where one of the picture's is one of the screen's, moire elsewhere.
function pattern() {
  if (!state.rig) return null;
  place();
  const { width, height } = state.rig;
  const image = context.createImageData(width, height);
  const words = new Uint32Array(image.data.buffer);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) words[y * width + x] = (x + y) % 2 ? 0xffffffff : 0xff000000;
  }
  context.putImageData(image, 0, 0);
  const back = new Uint32Array(context.getImageData(0, 0, width, height).data.buffer);
  return words.every((word, i) => word === back[i]);
}

function endPattern() {
  state.isPattern = false;
  if (state.image) context.putImageData(state.image, 0, 0);
  else context.clearRect(0, 0, canvas.width, canvas.height);
  check();
}

at("begin").addEventListener("click", begin);
at("pattern").addEventListener("click", () => {
  const isSame = pattern();
  state.isPattern = isSame !== null;
  check();
  prompt(...Array(2).fill(isSame ? "Even grey: pixel for pixel. Stripes or blotches: not. Tap." :
    "The browser changes pixels: switch off its data saver or night mode."));
});

function measure() {
  const length = Number(at("length").value);
  at("card").style.width = `${length}px`;
  const pitch = (1000 * CARD_MM) / (length * window.devicePixelRatio);
  at("pitch").textContent = `One pixel is ${pitch.toFixed(2)} um.`;
  return pitch;
}
at("measure").addEventListener("click", () => {
  // Wider than the screen no bar can be.
  at("length").max = Math.max(screen.width, screen.height);
  at("ruler").hidden = !at("ruler").hidden;
  measure();
});
at("length").addEventListener("input", measure);
// The screen's own pixels: counted where the page fills it, else as the browser rounds them.
async function screenSides() {
  await fillScreen();
  await new Promise((done) => setTimeout(done, 300));
  const ratio = window.devicePixelRatio, down = (a, b) => b - a;
  const told = [screen.width * ratio, screen.height * ratio].sort(down);
  const counted = [...viewPx()].sort(down);
  return counted.every((px, i) => Math.abs(px - told[i]) < ratio) ? counted : told.map(Math.round);
}
at("keep").addEventListener("click", async () => {
  const sides = await screenSides();
  send({ t: "panel", width: Math.max(...sides), height: Math.min(...sides), pitch_um: measure() });
});

function watchBox() {
  if (!window.ResizeObserver) return;
  const observer = new ResizeObserver((entries) => {
    const box = entries[0].devicePixelContentBoxSize;
    if (box && !canvas.hidden) state.boxPx = [box[0].inlineSize, box[0].blockSize];
    if (state.begun) check();
  });
  const screenful = new ResizeObserver((entries) => {
    const box = entries[0].devicePixelContentBoxSize;
    state.viewPx = box ? [box[0].inlineSize, box[0].blockSize] : null;
    check();
  });
  try {
    observer.observe(canvas, { box: "device-pixel-content-box" });
    screenful.observe(at("grey"), { box: "device-pixel-content-box" });
  } catch { /* not every browser has it */ }
}

for (const event of ["resize", "orientationchange", "fullscreenchange"]) {
  window.addEventListener(event, () => { if (state.isOpen) hello(); check(); });
}
// A pinch is no resize of the window.
if (window.visualViewport) window.visualViewport.addEventListener("resize", check);
watchBox();
connect();
check();
