// Entry point of the page that `sleight gallery` serves.
import { createServedSource } from "./data/served";
import { startApp } from "./ui/app";

startApp(createServedSource());
