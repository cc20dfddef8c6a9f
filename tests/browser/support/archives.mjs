// The test archives, one of each world, made once by real runs. They are in the folder SLEIGHT_BROWSER_DATA
// (set by ctest), or in a temporary folder. They are made again when the program or the requests change.
//
//   node support/archives.mjs [NAME...]      makes all archives, or the named ones
import { createHash } from "node:crypto";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, renameSync, rmSync, statSync } from "node:fs";
import { tmpdir, userInfo } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { besides, run, sleight, source } from "./programs.mjs";

/** Arguments of `sleight direct`. */
const runs = {
  // Found by search, so not in proportion.
  hi: [join(source, "tests/browser/hi.toml"), "--set", "stop.found=40"],
  // Drawn by a ladder, in proportion.
  dice: [join(source, "requests/die.toml"), "--set", "stop.rounds=2", "--set", "output.min_distance=0.2"],
  // A world that installed programs don't have.
  pucks: [join(source, "tests/browser/pucks.toml")],
  // Drawn by four plain chains.
  ball: [join(source, "requests/ball_2d.toml"), "--set", "stop.scans=400", "--set", "output.min_distance=0.05"],
};

function folder() {
  const { size, mtimeMs } = statSync(sleight);
  const asked = createHash("sha256").update(JSON.stringify(Object.values(runs)));
  for (const [request] of Object.values(runs)) asked.update(readFileSync(request));
  const of = process.env.SLEIGHT_BROWSER_DATA ?? join(tmpdir(), `sleight-browser-data-${userInfo().uid}`);
  return join(of, `${size}-${Math.round(mtimeMs)}-${asked.digest("hex").slice(0, 12)}`);
}

/** Paths of archives by name. REQUIRES: nobody changes these files. */
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
      // Another test made the archive first.
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
