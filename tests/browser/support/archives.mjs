// The archives that the tests look at, one of each world, made by real runs once for all: in the folder
// SLEIGHT_BROWSER_DATA (of ctest's), else in one of the system's temporary ones. They are made anew when
// the program or what is asked of it is another.
//
//   node support/archives.mjs      makes them
import { createHash } from "node:crypto";
import { cpSync, existsSync, mkdirSync, mkdtempSync, readFileSync, renameSync, rmSync, statSync } from "node:fs";
import { tmpdir, userInfo } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { besides, run, sleight, source } from "./programs.mjs";

/** Arguments of `sleight direct`. */
const runs = {
  // In no proportion: found by search.
  hi: [join(source, "tests/browser/hi.toml"), "--set", "stop.found=40"],
  // By a ladder, in proportion.
  dice: [join(source, "requests/die.toml"), "--set", "stop.rounds=2", "--set", "output.min_distance=0.2"],
  // Of a world that the installed programs don't know.
  pucks: [join(source, "tests/browser/pucks.toml")],
  // By four plain chains.
  ball: [join(source, "requests/ball_2d.toml"), "--set", "stop.scans=400", "--set", "output.min_distance=0.05"],
};

function folder() {
  const { size, mtimeMs } = statSync(sleight);
  const asked = createHash("sha256").update(JSON.stringify(Object.values(runs)));
  for (const [request] of Object.values(runs)) asked.update(readFileSync(request));
  const of = process.env.SLEIGHT_BROWSER_DATA ?? join(tmpdir(), `sleight-browser-data-${userInfo().uid}`);
  return join(of, `${size}-${Math.round(mtimeMs)}-${asked.digest("hex").slice(0, 12)}`);
}

/** Paths by name; nobody changes these files. */
export function archives() {
  const place = folder();
  const paths = Object.fromEntries(Object.keys(runs).map((name) => [name, join(place, `${name}.h5`)]));
  if (existsSync(place)) return paths;
  mkdirSync(join(place, ".."), { recursive: true });
  const making = mkdtempSync(`${place}-`);
  for (const [name, args] of Object.entries(runs))
    run(name === "pucks" ? besides("../failing/sleight") : sleight, ["direct", ...args, "-o", join(making, `${name}.h5`), "-q"]);
  try {
    renameSync(making, place);
  } catch (error) {
    // Another test was quicker.
    rmSync(making, { recursive: true });
    if (!existsSync(place)) throw error;
  }
  return paths;
}

/** Copies of some, which a test may change, in a folder of its own. */
export function copies(names, into) {
  const all = archives();
  return Object.fromEntries(names.map((name) => {
    const copy = join(into, `${name}.h5`);
    cpSync(all[name], copy);
    return [name, copy];
  }));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) console.log(JSON.stringify(archives()));
