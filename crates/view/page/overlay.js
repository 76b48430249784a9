// The overlay, drawn from the numbers themselves, so that lines stay sharp at any zoom.

/** Colors by track, well apart for the color-blind too (Okabe and Ito's palette). */
const COLORS = ["#e69f00", "#56b4e9", "#00a878", "#f0e442", "#d97fb0", "#e8602c"];
const HIDDEN = "#9aa4b0";
const GRID = "#5de0ff";
const CASING = "rgb(8 9 11 / 55%)";
/**
 * Size of an ellipse in standard deviations, and its magnification: most ellipses are a tenth of a
 * pixel.
 */
const SIGMAS = 3;
const LARGER = 10;

export const LAYERS = [
  { name: "picture", label: "Picture", on: true },
  { name: "curve", label: "Curve", on: true },
  { name: "centerline", label: "Centerline", on: true },
  { name: "control", label: "Control points", on: true },
  { name: "covariance", label: `Covariance ×${LARGER}`, on: false },
  { name: "crossings", label: "Crossings", on: true },
  { name: "hidden", label: "Hidden parts", on: true },
  { name: "tracks", label: "Tracks", on: true },
];

/**
 * Width of a thin line in CSS pixels. It grows with the text, for screens that are seen from afar.
 */
let unit = 1;

export function color(track) {
  return COLORS[track % COLORS.length];
}

/**
 * Draws over a canvas whose unit is a CSS pixel.
 *
 * @param {CanvasRenderingContext2D} pen
 * @param {{scale: number, x: number, y: number, unit: number}} view maps the image's pixels to the
 * canvas; `unit` is the width of a line
 * @param {Set<string>} layers
 */
export function draw(pen, said, view, layers) {
  const at = begin(pen, view);
  for (const rope of said.ropes) {
    if (layers.has("curve")) curve(pen, rope, at);
    if (layers.has("hidden")) hidden(pen, rope, at);
    if (layers.has("centerline")) centerline(pen, rope, at, view.scale);
    if (layers.has("covariance")) covariance(pen, rope, at, view.scale);
    if (layers.has("control")) control(pen, rope, at);
  }
  if (layers.has("crossings")) for (const crossing of said.crossings) over(pen, crossing, said.ropes, at, view.scale);
  if (layers.has("tracks")) for (const rope of said.ropes) track(pen, rope, at);
}

/**
 * Draws points that were clicked, and a grid on the table that they determine.
 *
 * @param {{points: number[][], lines: number[][][]}} marks in the image's pixels
 */
export function drawPlane(pen, { points, lines }, view) {
  const at = begin(pen, view);
  for (const points of lines) {
    line(pen, points, at, false);
    stroke(pen, 2.6, "rgb(8 9 11 / 35%)");
    stroke(pen, 1, GRID);
  }
  points.forEach((point, i) => {
    const [x, y] = at(point);
    const arm = 9 * unit;
    pen.beginPath();
    pen.moveTo(x - arm, y);
    pen.lineTo(x + arm, y);
    pen.moveTo(x, y - arm);
    pen.lineTo(x, y + arm);
    stroke(pen, 3.6, CASING);
    stroke(pen, 1.4, GRID);
    label(pen, `${i + 1}`, x, y);
  });
}

/** Sets up the pen. Returns a function from the image's pixels to the canvas. */
function begin(pen, view) {
  unit = view.unit ?? 1;
  pen.lineJoin = pen.lineCap = "round";
  // The center of the top-left pixel is (0, 0), and its corner is half a pixel before.
  return ([x, y]) => [(x + 0.5) * view.scale + view.x, (y + 0.5) * view.scale + view.y];
}

function line(pen, points, at, closed) {
  pen.beginPath();
  points.forEach((point, i) => pen[i ? "lineTo" : "moveTo"](...at(point)));
  if (closed) pen.closePath();
}

function stroke(pen, width, style) {
  pen.lineWidth = width * unit;
  pen.strokeStyle = style;
  pen.stroke();
}

function curve(pen, rope, at) {
  const points = rope.curve.length ? rope.curve : rope.points;
  if (points.length < 2) return;
  pen.globalAlpha = rope.status === "lost" ? 0.45 : 1;
  if (rope.status === "doubtful" || rope.coarse || rope.confidence < 0.5) pen.setLineDash([8 * unit, 6 * unit]);
  line(pen, points, at, rope.closed);
  stroke(pen, 4.5, CASING);
  stroke(pen, 2.4, color(rope.track));
  pen.setLineDash([]);
  pen.globalAlpha = 1;
}

function centerline(pen, rope, at, scale) {
  const radius = unit * Math.min(2.6, Math.max(1.1, scale * 0.4));
  pen.fillStyle = "#ffffff";
  pen.strokeStyle = CASING;
  pen.lineWidth = 0.8 * unit;
  pen.beginPath();
  for (const point of rope.points) {
    const [x, y] = at(point);
    pen.moveTo(x + radius, y);
    pen.arc(x, y, radius, 0, 2 * Math.PI);
  }
  pen.stroke();
  pen.fill();
}

/** Draws runs of covered points, each with the visible point at either end. */
function hidden(pen, rope, at) {
  if (!rope.hidden.length) return;
  const covered = new Set(rope.hidden);
  pen.setLineDash([2 * unit, 6 * unit]);
  for (let i = 0; i < rope.points.length; i += 1) {
    if (!covered.has(i)) continue;
    let end = i;
    while (covered.has(end + 1)) end += 1;
    line(pen, rope.points.slice(Math.max(0, i - 1), end + 2), at, false);
    stroke(pen, 6, CASING);
    stroke(pen, 3.4, HIDDEN);
    i = end;
  }
  pen.setLineDash([]);
}

function control(pen, rope, at) {
  if (rope.control.length < 2) return;
  pen.globalAlpha = 0.55;
  line(pen, rope.control, at, false);
  stroke(pen, 1, color(rope.track));
  pen.globalAlpha = 1;
  for (const point of rope.control) {
    const [x, y] = at(point);
    pen.beginPath();
    pen.arc(x, y, 4 * unit, 0, 2 * Math.PI);
    pen.fillStyle = "rgb(8 9 11 / 35%)";
    pen.fill();
    stroke(pen, 1.6, color(rope.track));
  }
}

function covariance(pen, rope, at, scale) {
  rope.control.forEach((point, i) => {
    const [xx, xy, yy] = rope.covariances[i] ?? [0, 0, 0];
    const middle = (xx + yy) / 2;
    const apart = Math.hypot((xx - yy) / 2, xy);
    const radius = (variance) => SIGMAS * LARGER * scale * Math.sqrt(Math.max(0, variance));
    const [x, y] = at(point);
    pen.beginPath();
    pen.ellipse(x, y, radius(middle + apart), radius(middle - apart), Math.atan2(2 * xy, xx - yy) / 2, 0, 2 * Math.PI);
    pen.fillStyle = `${color(rope.track)}33`;
    pen.fill();
    stroke(pen, 1, color(rope.track));
  });
}

/**
 * Draws the upper strand as a short bar over the lower one, in a ring. The arc of the ring shows
 * the confidence.
 */
function over(pen, crossing, ropes, at, scale) {
  const [x, y] = at(crossing.at);
  const upper = ropes.find((rope) => rope.track === crossing.over);
  const radius = Math.max(8 * unit, (upper?.width_px ?? 10) * scale * 0.95);
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  stroke(pen, 3.5, CASING);
  stroke(pen, 1.2, "rgb(255 255 255 / 40%)");
  pen.beginPath();
  pen.arc(x, y, radius, -Math.PI / 2, -Math.PI / 2 + 2 * Math.PI * crossing.confidence);
  stroke(pen, 1.8, "#ffffff");
  const count = upper?.points.length ?? 0;
  if (count < 3) return;
  const place = Math.min(count - 2, Math.max(1, Math.round(crossing.over_rho * (count - 1))));
  const [[ax, ay], [bx, by]] = [at(upper.points[place - 1]), at(upper.points[place + 1])];
  const length = Math.hypot(bx - ax, by - ay) || 1;
  const [dx, dy] = [((bx - ax) / length) * radius * 0.72, ((by - ay) / length) * radius * 0.72];
  pen.beginPath();
  pen.moveTo(x - dx, y - dy);
  pen.lineTo(x + dx, y + dy);
  stroke(pen, 6.5, "rgb(8 9 11 / 80%)");
  stroke(pen, 3, color(crossing.over));
}

/** Draws the first end, with the rope's number. */
function track(pen, rope, at) {
  const first = rope.curve[0] ?? rope.points[0];
  if (!first) return;
  const [x, y] = at(first);
  pen.beginPath();
  pen.arc(x, y, 6 * unit, 0, 2 * Math.PI);
  pen.fillStyle = color(rope.track);
  pen.fill();
  stroke(pen, 1.5, "#ffffff");
  const text = rope.status === "ok" || !rope.status ? `${rope.track}` : `${rope.track} ${rope.status}`;
  label(pen, text, x, y);
}

/** Draws a word next to a position. */
function label(pen, text, x, y) {
  pen.font = `600 ${12 * unit}px system-ui, sans-serif`;
  pen.lineWidth = 3.5 * unit;
  pen.strokeStyle = "rgb(8 9 11 / 75%)";
  pen.strokeText(text, x + 10 * unit, y - 7 * unit);
  pen.fillStyle = "#ffffff";
  pen.fillText(text, x + 10 * unit, y - 7 * unit);
}
