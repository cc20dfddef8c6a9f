// Entry point of a saved gallery's page, which has no server (data/saved.ts).
import { createSavedSource } from "./data/saved";
import { startApp } from "./ui/app";

startApp(createSavedSource());
