// The archives that the tests look at, one of each world, made by real runs once for all: in the folder
// SLEIGHT_BROWSER_DATA (of ctest's), else in one of the system's temporary ones. They are made anew when
// the program or what is asked of it is another.
//
//   node support/archives.mjs [NAME...]      makes them, or those
import { createHash } from "node:crypto";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, renameSync, rmSync, statSync } from "node:fs";
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

/** Paths by name of those that are asked for; nobody changes these files. */
export function archives(names = Object.keys(runs)) {
  const all = folder();
  mkdirSync(all, { recursive: true });
  return Object.fromEntries(names.map((name) => {
    const place = join(all, name);
    const path = join(place, `${name}.h5`);
    if (existsSync(place)) return [name, path];
    const making = mkdtempSync(`${place}-`);
    run(name === "pucks" ? besides("../failing/sleight") : sleight,
      ["direct", ...runs[name], "-o", join(making, `${name}.h5`), "-q"]);
    try {
      renameSync(making, place);
    } catch (error) {
      // Another test was quicker.
      rmSync(making, { recursive: true });
      if (!existsSync(place)) throw error;
    }
    return [name, path];
  }));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const names = process.argv.slice(2);
  console.log(JSON.stringify(archives(names.length > 0 ? names : undefined)));
}
