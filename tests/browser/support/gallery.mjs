// A running gallery: `sleight gallery` on its own port.
import { createServer } from "node:net";
import { ended, firstLine, sleight, start, temporaryFolder } from "./programs.mjs";

/** A free port. */
export function freePort() {
  return new Promise((resolve, reject) => {
    const server = createServer();
    server.on("error", reject);
    server.listen(0, "127.0.0.1", () => {
      const { port } = server.address();
      server.close(() => resolve(port));
    });
  });
}

export class Gallery {
  /** `program`: another program than the tested one, with other worlds. */
  static async start(paths, { home, port, args = [], program = sleight, cwd, env } = {}) {
    const gallery = new Gallery();
    gallery.home = home ?? temporaryFolder("home");
    gallery.port = port ?? (await freePort());
    gallery.program = program;
    gallery.cwd = cwd;
    gallery.env = env;
    gallery.args = ["gallery", ...paths, "--no-browser", "--json", "--port", String(gallery.port), ...args];
    await gallery.begin();
    return gallery;
  }

  async begin() {
    this.child = start(this.program, this.args, { home: this.home, cwd: this.cwd, env: this.env });
    this.errors = "";
    this.child.stderr.on("data", (data) => { this.errors += data; });
    const { link } = JSON.parse(await firstLine(this.child));
    /** Authorizes one browser. */
    this.link = link;
  }

  get origin() { return `http://127.0.0.1:${this.port}`; }
  get pid() { return this.child.pid; }

  /** Ends the gallery as Ctrl-C does; returns its exit code. */
  async stop() {
    this.child.kill("SIGINT");
    return (await ended(this.child)).code;
  }
  async kill() {
    this.child.kill("SIGKILL");
    await ended(this.child);
  }
}
