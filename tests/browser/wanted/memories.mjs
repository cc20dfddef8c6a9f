// Makes rough memories of animations, as people have them. This code reads the archive; the search gets only
// the memory, and knows the scene.
//
// A memory contains no name and no exact number:
//
//   rests    the colour in each bin at the end; bins count from the picture's left and bottom
//   first    the bin of the ball that fell first; last: the bin of the last ball
//   contact  of one hit: the ball's colour, its place to 10 mm and its time to 0.2 s
import { run, sleight } from "../support/programs.mjs";
import { rgbOf, wordOf } from "./colours.mjs";

const binPitchM = 0.022;
/** A hit that nobody could miss changes the velocity by this. */
const plainHitMps = 0.5;
const causeHit = 1;

/** `count` random targets: [{name, memory}]. `colours`: "#rrggbb" of each ball. */
export function makeTargets({ archive, colours, count, random }) {
  const names = run(sleight, ["find", archive, "--ids"]).trim().split(/\s+/);
  const chosen = random.some(names, count);
  const segments = ["--format", "csv", "--table", "segments", "--ids", ...chosen];
  const rows = tableOf(run(sleight, ["export", archive, ...segments]));
  return chosen.map((name) => ({
    name,
    memory: memoryOf(rows.filter((row) => row.id === name), colours, random),
  }));
}

function tableOf(csv) {
  const [head, ...lines] = csv.trim().split("\n").map((line) => line.split(","));
  return lines.map((line) => Object.fromEntries(head.map((column, i) => [column, line[i]])));
}

function memoryOf(rows, colours, random) {
  const segments = rows.map((row) => ({
    body: Number(row.body),
    startS: Number(row.start_s),
    cause: Number(row.cause),
    partner: Number(row.partner),
    place: vectorOf(row, "position_m"),
    velocity: vectorOf(row, "velocity_mps"),
    acceleration: vectorOf(row, "acceleration_mps2"),
  }));
  const bodies = colours.map((_, body) => segments.filter((segment) => segment.body === body));
  const word = (body) => wordOf(rgbOf(colours[body]));
  const rests = bodies.map((own, body) => ({ word: word(body), ...binOf(own.at(-1).place) }));
  const falls = bodies.map((own, body) => ({ body, atS: own[0].startS })).sort((a, b) => a.atS - b.atS);
  const binOfBody = (body) => binOf(bodies[body].at(-1).place);
  return {
    // Sorted by place, so that the order doesn't reveal invisible information.
    rests: rests.sort((a, b) => b.row - a.row || a.column - b.column),
    first: binOfBody(falls[0].body),
    last: binOfBody(falls.at(-1).body),
    contact: contactOf(bodies, word, random),
  };
}

function contactOf(bodies, word, random) {
  const hits = bodies.flatMap((own) =>
    own.filter(
      (segment, i) => segment.cause === causeHit && i > 0 && changeAt(own[i - 1], segment) >= plainHitMps,
    ),
  );
  const hit = random.of(hits);
  return {
    word: word(hit.body),
    withBall: hit.partner >= 0 && hit.partner < bodies.length,
    xMm: roundedTo(hit.place[0] * 1000, 10),
    yMm: roundedTo(hit.place[1] * 1000, 10),
    atS: roundedTo(hit.startS, 0.2),
  };
}

function changeAt(before, segment) {
  const t = segment.startS - before.startS;
  return Math.hypot(
    ...segment.velocity.map((value, axis) => value - before.velocity[axis] - before.acceleration[axis] * t),
  );
}

/** Column 1 is leftmost, row 1 is nearest, of seven each. */
function binOf(place) {
  return { column: Math.round(place[0] / binPitchM) + 4, row: Math.round(place[1] / binPitchM) + 4 };
}

function vectorOf(row, column) {
  return [0, 1, 2].map((axis) => Number(row[`${column}[${axis}]`]));
}

function roundedTo(value, step) {
  return Math.round(value / step) * step;
}
