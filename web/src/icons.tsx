/** All icons, drawn on a grid of 16 with lines of 1.5; they take the colour of the text. */

const PATHS = {
  new: "M3.5 2h6l3 3v9h-9zM9.5 2v3h3",
  axes: "M3 13V3M3 13h10M3 13l4-4M1.5 4.5L3 3l1.5 1.5M11.5 11.5L13 13l-1.5 1.5",
  scale: "M2 10V6M14 10V6M2 8h12M5 9V7M8 9V7M11 9V7",
  open: "M2 12.5v-9h4l1.5 2H13v2M2 12.5l2-5h11l-2 5z",
  add: "M8 3v10M3 8h10",
  save: "M3 2.5h8L13.5 5v8.5h-10.5zM5 2.5v3.5h5v-3.5M5 13.5v-4h6v4",
  picture: "M2 3.5h12v9H2zM2 11l3.5-3.5 3 3 2-2L14 12M10.5 6h.01",
  terminal: "M2 3h12v10H2zM4.5 6l2 2-2 2M8.5 10h3",
  undo: "M5.5 3L2.5 6l3 3M2.5 6h7a3.5 3.5 0 0 1 0 7H6",
  redo: "M10.5 3l3 3-3 3M13.5 6h-7a3.5 3.5 0 0 0 0 7H10",
  search: "M7 2.5a4.5 4.5 0 1 0 0 9a4.5 4.5 0 1 0 0-9M10.5 10.5L14 14",
  help: "M8 1.75a6.25 6.25 0 1 0 0 12.5a6.25 6.25 0 1 0 0-12.5M6.25 6.25a1.75 1.75 0 1 1 2.5 1.6c-.5.25-.75.6-.75 1.15M8 11.25h.01",
  theme: "M8 2a6 6 0 1 0 0 12a6 6 0 1 0 0-12M8 2v12M8 5h4.5M8 8h6M8 11h4.5",
  "panel-left": "M2 3h12v10H2zM6 3v10",
  split: "M2 3h12v10H2zM8 3v10",
  slices: "M2 2.5h12v11H2zM8 2.5v11M2 8h12",
  maximise: "M2.5 6v-3.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10",
  "panel-right": "M2 3h12v10H2zM10 3v10",
  rest: "M3 2.5h10v8H3zM6 13.5h4M8 10.5v3M5.5 8l2-2.5 1.5 1.5 1.5-2",
  fit: "M2.5 5.5v-3h3M10.5 2.5h3v3M13.5 10.5v3h-3M5.5 13.5h-3v-3M6 6h4v4H6z",
  view: "M8 2l5 2.75v6.5L8 14l-5-2.75v-6.5zM3 4.75L8 7.5l5-2.75M8 7.5V14",
  projection: "M2 8l11-5v10zM8.5 5.05v5.9",
  light: "M8 5a3 3 0 1 0 0 6a3 3 0 1 0 0-6M8 1.5v1M8 13.5v1M1.5 8h1M13.5 8h1M3.4 3.4l.7.7M11.9 11.9l.7.7M3.4 12.6l.7-.7M11.9 4.1l.7-.7",
  cut: "M2 11l6 3 6-3-6-3zM8 8V2M5.5 4.5L8 2l2.5 2.5",
  operation: "M8 5.5a2.5 2.5 0 1 0 0 5a2.5 2.5 0 1 0 0-5M8 1.5v2M8 12.5v2M1.5 8h2M12.5 8h2M3.4 3.4l1.4 1.4M11.2 11.2l1.4 1.4M3.4 12.6l1.4-1.4M11.2 4.8l1.4-1.4",
  transfer: "M2 13h12M2.5 11c2.5 0 2.5-7 5-7s2 4 3.5 4 1.5-4 3-4",
  render: "M8 2a6 6 0 1 0 0 12a6 6 0 1 0 0-12M5 5.5a4 4 0 0 1 2.5-1.3",
  property: "M2.5 4.5h11M2.5 8h11M2.5 11.5h11M5 3v3M10.5 6.5v3M6.5 10v3",
  volume: "M8 2l5 2.75v6.5L8 14l-5-2.75v-6.5zM3 4.75L8 7.5l5-2.75M8 7.5V14M5.5 3.4l5 2.75M10.5 3.4l-5 2.75",
  dataset: "M8 2.5c3 0 5 .8 5 2s-2 2-5 2-5-.8-5-2 2-2 5-2M3 4.5v7c0 1.2 2 2 5 2s5-.8 5-2v-7M3 8c0 1.2 2 2 5 2s5-.8 5-2",
  camera: "M2 5h3l1-2h4l1 2h3v8H2zM8 6.5a2.25 2.25 0 1 0 0 4.5a2.25 2.25 0 1 0 0-4.5",
  measure: "M1.5 11l9.5-9.5 3.5 3.5L5 14.5zM4.5 8l1.5 1.5M7 5.5L8.5 7M9.5 3L11 4.5",
  world: "M8 2a6 6 0 1 0 0 12a6 6 0 1 0 0-12M2 8h12M8 2c2 1.7 2.5 4 2.5 6s-.5 4.3-2.5 6c-2-1.7-2.5-4-2.5-6S6 3.7 8 2",
  eye: "M1.5 8c1.7-3 4-4.25 6.5-4.25S12.8 5 14.5 8c-1.7 3-4 4.25-6.5 4.25S3.2 11 1.5 8zM8 6a2 2 0 1 0 0 4a2 2 0 1 0 0-4",
  "eye-off": "M2.5 2.5l11 11M6.2 4a7 7 0 0 1 1.8-.25c2.5 0 4.8 1.25 6.5 4.25a10 10 0 0 1-1.8 2.3M4.3 5.2A9.5 9.5 0 0 0 1.5 8c1.7 3 4 4.25 6.5 4.25a7 7 0 0 0 2.8-.55",
  reset: "M3 8a5 5 0 1 1 1.5 3.55M3 12.5V8.5h4",
  close: "M4 4l8 8M12 4l-8 8",
  remove: "M3 4.5h10M6.5 4.5v-2h3v2M4.5 4.5l.5 9h6l.5-9M6.75 7v4M9.25 7v4",
  right: "M6 3.5L10.5 8 6 12.5",
  down: "M3.5 6L8 10.5 12.5 6",
  up: "M3.5 10L8 5.5 12.5 10",
  folder: "M2 12.5v-9h4l1.5 2H14v7z",
  file: "M4 2h5l3 3v9H4zM9 2v3h3",
  mesh: "M8 2l6 11H2zM8 2v11M5 7.5l6 0M2 13l9-5.5M14 13L5 7.5",
  scene: "M2 3h12v10H2zM2 6h12M5 9h3M5 11h6",
  minus: "M3 8h10",
  check: "M3 8.5l3.5 3.5L13 4.5",
  warning: "M8 2.5L14.5 13.5h-13zM8 6.5v3.5M8 12h.01",
  error: "M8 1.75a6.25 6.25 0 1 0 0 12.5a6.25 6.25 0 1 0 0-12.5M8 4.75v4M8 11.25h.01",
  info: "M8 1.75a6.25 6.25 0 1 0 0 12.5a6.25 6.25 0 1 0 0-12.5M8 7.25v4M8 4.75h.01",
  copy: "M5.5 5.5h8v8h-8zM10.5 5.5v-3h-8v8h3",
  unplugged: "M6 2v3M10 2v3M4.5 5h7v3a3.5 3.5 0 0 1-7 0zM8 11.5v3",
  people: "M6 3a2.25 2.25 0 1 0 0 4.5a2.25 2.25 0 1 0 0-4.5M1.5 13c0-2.5 2-4 4.5-4s4.5 1.5 4.5 4M10.5 3.2a2.25 2.25 0 0 1 0 4.2M12 9.3c1.5.6 2.5 1.9 2.5 3.7",
} as const;

export type IconName = keyof typeof PATHS;

export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 16 16" width="16" height="16" aria-hidden="true" focusable="false">
      <path d={PATHS[name]} />
    </svg>
  );
}
