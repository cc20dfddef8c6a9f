// Entry point of a saved gallery's page, which has no server (data/saved.ts).
import "./styles/base.css";
import "./styles/layout.css";
import "./styles/filters.css";
import "./styles/wall.css";
import "./styles/player.css";
import "./styles/plots.css";
import { createSavedSource } from "./data/saved";
import { startApp } from "./ui/app";
import { installTestHook } from "./view/test-hook";

const root = document.getElementById("app");
if (root !== null) {
  const app = startApp(root, createSavedSource());
  installTestHook(app.renderer, app.player);
}
