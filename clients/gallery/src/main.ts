// Entry point of the page that `sleight gallery` serves.
import "./styles/base.css";
import "./styles/layout.css";
import "./styles/filters.css";
import "./styles/wall.css";
import "./styles/player.css";
import "./styles/plots.css";
import { createServedSource } from "./data/served";
import { startApp } from "./ui/app";
import { installTestHook } from "./view/test-hook";

const root = document.getElementById("app");
if (root !== null) {
  const app = startApp(root, createServedSource());
  installTestHook(app.renderer, app.player);
}
