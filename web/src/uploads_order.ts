/** Of files that are dropped: which are opened, and in which order. */
const MOST = 16;
export const HEADER = /\.(nhdr|mhd|hdr|vv\.json)$/i;
const SLICE = /\.(dcm|ima)$/i;
/** What a header beside it reads. */
export const SAMPLES = /\.(raw|zraw|img|bin|dat|data)(\.(gz|bz2|zst))?$/i;

/** In which order: headers first, without the samples that they read. */
export function toBeOpened<T extends { name: string }>(files: T[]): T[] {
  const headers = files.filter((file) => HEADER.test(file.name));
  const others = files.filter((file) => !headers.includes(file));
  return headers.length ? [...headers, ...others.filter((file) => !SAMPLES.test(file.name))] : others;
}

/** Why these are not taken; "": they are. */
export function whyNot(files: { name: string; size: number }[]): string {
  const empty = files.find((file) => file.size === 0);
  if (empty) return `${empty.name} is empty, or a folder: there is nothing to open.`;
  if (files.filter((file) => SLICE.test(file.name)).length > 1 || files.length > MOST)
    return "This many files, or slices of one series, are opened as a folder: put it on the server, and open it there.";
  return "";
}
