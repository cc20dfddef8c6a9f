// Goal: only the authorized page can read or change anything. Pages under another host name of the same
// address, foreign pages in the same browser, and other programs on the host must be refused. Method: run the
// real program, with Chromium as the victim's browser. Open the gallery under another host name that maps to
// loopback, and attack it from a page on another port. Refusals must not reveal the content.
// tests/unit/clients/web tests hand-made requests.
import assert from "node:assert/strict";
import { copyFileSync, mkdirSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { archives } from "./support/archives.mjs";
import { Visitor } from "./support/browser.mjs";
import { Gallery } from "./support/gallery.mjs";
import { namesFound, temporaryFolder } from "./support/programs.mjs";

const folder = temporaryFolder("hostile");
const { hi } = archives();
// A file name full of special characters.
const odd = `<img src=x onerror=alert(1)>"'&\u202e javascript:alert(2) %00..`;
const shown = join(folder, "shown");
mkdirSync(shown);
copyFileSync(hi, join(shown, `${odd}.h5`));
writeFileSync(join(shown, `<script>alert(3)<script>.h5`), "no archive");

let gallery, visitor, page;
before(async () => {
  gallery = await Gallery.start([shown]);
  visitor = await Visitor.enter(gallery, { rules: "MAP evil.test 127.0.0.1" });
  page = visitor.page;
});
after(async () => {
  await visitor?.close();
  await gallery?.stop();
});

const notesNow = () => page.evaluate(async () => (await fetch("/api/notes")).text());

/** Starts another person's server on this host. It serves `pages` (path -> HTML) and records its requests. */
async function foreignServer(pages) {
  const asked = [];
  const server = createServer((request, response) => {
    asked.push({ url: request.url, cookie: request.headers.cookie ?? "" });
    response.setHeader("content-type", "text/html");
    response.end(pages[request.url] ?? "");
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { asked, port: server.address().port, close: () => server.close() };
}

test("another name of this address is refused", async () => {
  const other = await visitor.context.newPage();
  const answer = await other.goto(`http://evil.test:${gallery.port}/`);
  assert.ok([400, 403, 421].includes(answer.status()), `${answer.status()}`);
  const body = await answer.text();
  assert.doesNotMatch(body, /evil\.test|sleight-gallery-root|app"/);
  // The browser treats this page's requests as same-origin, but the server must refuse them anyway.
  const tried = await other.evaluate(async () => {
    const status = async (path, options) => (await fetch(path, options)).status;
    return [await status("/api/gallery"), await status("/api/notes"), await status("/"),
      await status("/api/notes", { method: "POST", headers: { "content-type": "application/json" },
        body: JSON.stringify({ run: "0123456789abcdef", name: "c0.1", note: { star: true } }) })];
  });
  for (const status of tried) assert.ok(status >= 400 && status < 500, tried.join());
  await other.close();
});

test("a foreign page reads nothing and changes nothing", async () => {
  const before = await notesNow();
  const run = await page.evaluate(async () => (await (await fetch("/api/gallery")).json()).archives
    .find(({ state }) => state === "ready").run);
  const [name] = namesFound(hi);
  const note = JSON.stringify({ run, name, note: { star: true, hidden: true, tags: ["evil"], note: "evil" } });
  const { origin } = gallery;
  const foreign = await foreignServer({
    "/": `<!doctype html><title>foreign</title><p>hello</p>`,
    "/form": `<!doctype html><form method=post action="${origin}/api/notes" enctype="text/plain">` +
      `<input name='${note.slice(0, -1).replaceAll("'", "&#39;")},"x":"' value='"}'></form>`,
  });
  try {
    // It has the gallery's host but another port, so the browser sends the gallery's cookie to it.
    const other = await visitor.context.newPage();
    await other.goto(`http://127.0.0.1:${foreign.port}/`);
    const said = await other.evaluate(async ([at, body]) => {
      const tries = {};
      const attempt = async (what, act) => {
        try {
          tries[what] = await act();
        } catch (error) {
          tries[what] = `refused: ${error.name}`;
        }
      };
      const credentials = "include";
      for (const path of ["/", "/api/gallery", "/api/notes", "/api/archives/0/table"]) {
        await attempt(`read ${path}`, async () => (await fetch(at + path, { credentials })).text());
        await attempt(`opaque ${path}`, async () =>
          (await (await fetch(at + path, { credentials, mode: "no-cors" })).text()).length);
      }
      await attempt("post", async () => (await fetch(`${at}/api/notes`, { method: "POST", credentials, body,
        headers: { "content-type": "application/json" } })).text());
      await attempt("plain post", async () => (await fetch(`${at}/api/notes`, { method: "POST", credentials, body,
        mode: "no-cors", headers: { "content-type": "text/plain" } })).type);
      await attempt("beacon", () => navigator.sendBeacon(`${at}/api/notes`,
        new Blob([body], { type: "application/json" })));
      const element = (tag, attributes) => new Promise((resolve) => {
        const made = document.createElement(tag);
        made.onload = () => resolve("loaded");
        made.onerror = () => resolve("refused");
        Object.assign(made, attributes);
        document.body.append(made);
        setTimeout(() => resolve("nothing"), 2000);
      });
      await attempt("image", () => element("img", { src: `${at}/api/gallery` }));
      await attempt("script", () => element("script", { src: `${at}/api/gallery` }));
      await attempt("style", () => element("link", { rel: "stylesheet", href: `${at}/` }));
      await attempt("events", () => new Promise((resolve) => {
        const events = new EventSource(`${at}/api/events`, { withCredentials: true });
        events.onopen = () => resolve("open");
        events.onerror = () => { events.close(); resolve("refused"); };
      }));
      const frame = document.createElement("iframe");
      frame.src = `${at}/`;
      document.body.append(frame);
      /** Waits until the condition holds, for at most 15 s. */
      const soon = async (holds) => {
        for (let i = 0; i < 300 && !holds(); ++i) await new Promise((resolve) => setTimeout(resolve, 50));
      };
      // Until the other page loads, the frame contains an empty page of the same origin.
      await soon(() => frame.contentDocument === null);
      await attempt("frame", () => frame.contentDocument?.body.textContent ?? "refused");
      const opened = window.open(`${at}/`);
      await soon(() => {
        try {
          return opened === null || opened.closed || opened.location.href !== "about:blank";
        } catch {
          return true;
        }
      });
      await attempt("window", () => opened?.document?.body.textContent ?? "refused");
      opened?.close();
      return tries;
    }, [origin, note]);
    for (const [what, result] of Object.entries(said)) {
      if (what === "beacon") continue;
      if (what.startsWith("opaque") || what === "plain post") {
        assert.ok(result === 0 || result === "opaque" || /refused/.test(result), `${what}: ${result}`);
        continue;
      }
      assert.match(String(result), /^refused|^nothing$/, `${what}: ${String(result).slice(0, 200)}`);
    }
    // The gallery's page must not load in a foreign frame: the frame contains Chromium's refusal.
    for (const child of other.frames().slice(1))
      assert.equal(await child.locator("#counts").count().catch(() => 0), 0);
    await other.goto(`http://127.0.0.1:${foreign.port}/form`);
    const [answer] = await Promise.all([other.waitForNavigation(), other.evaluate(() => document.forms[0].submit())]);
    assert.ok(answer.status() >= 400 && answer.status() < 500, `the form got ${answer.status()}`);
    await other.close();
    assert.equal(await notesNow(), before);
  } finally {
    foreign.close();
  }
});

test("names of files stay text", async () => {
  await visitor.open();
  assert.ok((await page.locator("nav[aria-label=Archives]").innerText()).includes(odd.slice(0, 30)));
  assert.ok((await page.locator("nav[aria-label=Archives]").innerText()).includes("<script>alert(3)<script>.h5 (damaged)"));
  assert.equal(await page.locator("script:not([src]), [onerror], [onload], a[href^='javascript:']").count(), 0);
  assert.equal(await page.locator("img").count(), 0);
  // Names in links and selections stay text too.
  await visitor.open(`#archive=${encodeURIComponent(`${odd}.h5`)}&q=in:${encodeURIComponent("<img src=x onerror=alert(4)>")}&tag=${encodeURIComponent("<b>")}`);
  assert.equal(await page.locator("#chips .chip-text").innerText(), "<img src=x onerror=alert(4)>");
  assert.equal(await page.locator("img, b").count(), 0);
  visitor.assertNoProblems(/status of 4\d\d|ERR_BLOCKED|Refused to|CORS|MIME type/);
});

test("the page's security policy works", async () => {
  await visitor.open();
  const tried = await page.evaluate(async () => {
    const tries = {};
    // Uses a timer, because code from a debugger may evaluate strings.
    try { setTimeout("window.wasEvaluated = true"); } catch { /* refused */ }
    await new Promise((resolve) => setTimeout(resolve, 50));
    tries.evaluated = window.wasEvaluated ?? "refused";
    const script = document.createElement("script");
    script.textContent = "window.wasRun = true";
    document.body.append(script);
    tries.inline = window.wasRun ?? "refused";
    const div = document.createElement("div");
    div.setAttribute("onclick", "window.wasClicked = true");
    document.body.append(div);
    div.click();
    tries.attribute = window.wasClicked ?? "refused";
    try { await fetch("http://127.0.0.1:1/"); tries.fetch = "sent"; } catch { tries.fetch = "refused"; }
    return tries;
  });
  assert.deepEqual(tried, { evaluated: "refused", inline: "refused", attribute: "refused", fetch: "refused" });
  visitor.problems.length = 0;
});
