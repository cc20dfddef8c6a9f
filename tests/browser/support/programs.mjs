// Finds and runs the programs. SLEIGHT_BIN, or `--bin`, is the program `sleight` or its folder. Programs get
// their own home folder, so that tests don't share notes.
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

/** The folder of the sources. */
export const source = resolve(dirname(fileURLToPath(import.meta.url)), "../../..");

function given() {
  const at = process.argv.indexOf("--bin");
  const path = process.env.SLEIGHT_BIN ?? (at > 0 ? process.argv[at + 1] : undefined);
  if (path === undefined) throw new Error("set SLEIGHT_BIN to the programs' folder: SLEIGHT_BIN=build/release_part/bin");
  if (!existsSync(path)) throw new Error(`SLEIGHT_BIN: ${path} doesn't exist; build the programs first`);
  return resolve(statSync(path).isDirectory() ? join(path, "sleight") : path);
}

export const sleight = given();
/** Another program in the same folder. */
export const besides = (name) => join(dirname(sleight), name);
/** A program that is not installed. */
export const testProgram = (name) => join(dirname(sleight), "../tests", name);

const temporary = [];
process.on("exit", () => {
  for (const folder of temporary) rmSync(folder, { recursive: true, force: true });
});
/** A folder that is removed when the tests end. */
export function temporaryFolder(name = "test") {
  const folder = mkdtempSync(join(tmpdir(), `sleight-browser-${name}-`));
  temporary.push(folder);
  return folder;
}

/** The environment of programs with this home. As root, Open MPI runs only if explicitly allowed. */
export function environment(home, more = {}) {
  const { XDG_CACHE_HOME, XDG_DATA_HOME, XDG_STATE_HOME, XDG_RUNTIME_DIR, DISPLAY, WAYLAND_DISPLAY, ...rest } =
    process.env;
  mkdirSync(home, { recursive: true });
  return { ...rest, OMPI_ALLOW_RUN_AS_ROOT: "1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM: "1", SLEIGHT_ALLOW_ROOT: "1", HOME: home, ...more };
}

let homeOfRuns = null;
/** Runs a program to its end; returns its output. Throws if its exit code isn't in `codes`. */
export function run(program, args, { input, home, cwd, env, codes = [0] } = {}) {
  homeOfRuns ??= temporaryFolder("home");
  const { status, signal, stdout, stderr, error } = spawnSync(program, args, {
    env: environment(home ?? homeOfRuns, env), input, cwd, encoding: "utf8", maxBuffer: 1 << 30,
  });
  if (error !== undefined) throw error;
  if (!codes.includes(status)) throw new Error(`${program} ${args.join(" ")}: ended with ${status ?? signal}: ${stderr}`);
  return stdout;
}

/** The JSON output of `sleight find` for an archive. */
export function find(archive, ...args) {
  return JSON.parse(run(sleight, ["find", archive, ...args, "--json"]));
}
/** Names of the animations that match. */
export const namesFound = (archive, ...args) => find(archive, ...args).animations.map(({ id }) => id);

for (const signal of ["SIGTERM", "SIGINT", "SIGHUP"]) process.on(signal, () => process.exit(1));
const running = new Set();
process.on("exit", () => {
  for (const child of running) child.kill("SIGKILL");
});
/** Starts a program, which ends with the tests. */
export function start(program, args, { home, env, ...options }) {
  // It also ends if the tests are killed.
  const child = spawn("setpriv", ["--pdeathsig", "KILL", program, ...args], {
    env: environment(home, env), stdio: ["ignore", "pipe", "pipe"], ...options,
  });
  running.add(child);
  child.on("exit", () => running.delete(child));
  return child;
}

/** The program's first line; throws with its stderr if the program ends before. */
export function firstLine(child) {
  return new Promise((resolveLine, reject) => {
    let text = "";
    let errors = "";
    child.stderr.on("data", (data) => { errors += data; });
    child.stdout.on("data", (data) => {
      text += data;
      if (text.includes("\n")) resolveLine(text.slice(0, text.indexOf("\n")));
    });
    child.on("error", reject);
    child.on("exit", (code, signal) =>
      reject(new Error(`${child.spawnargs.join(" ")}: ended with ${code ?? signal}: ${errors}`)));
  });
}

/** How the program ended: {code, signal}. */
export function ended(child) {
  if (child.exitCode !== null || child.signalCode !== null)
    return Promise.resolve({ code: child.exitCode, signal: child.signalCode });
  return new Promise((resolveEnd) => child.on("exit", (code, signal) => resolveEnd({ code, signal })));
}
