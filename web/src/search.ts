/** How well words that were typed fit: all of them must be found, in any order, in a title or in what is said of it. */

/** 0: it is not in it; larger is better: all of it, at the beginning, at the beginning of a word, anywhere. */
function scoreOfWord(word: string, text: string): number {
  const at = text.indexOf(word);
  if (at < 0) return 0;
  if (text === word) return 16;
  return at === 0 ? 8 : /\W/.test(text[at - 1]!) ? 4 : 1;
}

const TITLE_COUNTS = 8; // a word of the title is worth more than any of the text about it

/** texts: the title first. */
export function scoreOf(query: string, texts: readonly string[]): number {
  let score = 0;
  for (const word of query.toLowerCase().split(/\s+/).filter(Boolean)) {
    const scores = texts.map((text, i) => scoreOfWord(word, text.toLowerCase()) * (i === 0 ? TITLE_COUNTS : 1));
    const best = Math.max(0, ...scores);
    if (best === 0) return 0;
    score += best;
  }
  return score - (texts[0]?.length ?? 0) / 1000;
}

/** The best first; of equal ones the order stays. */
export function findBest<T>(query: string, items: readonly T[], textsOf: (item: T) => readonly string[], most: number): T[] {
  if (!query.trim()) return items.slice(0, most);
  return items
    .map((item, i) => ({ item, i, score: scoreOf(query, textsOf(item)) }))
    .filter(({ score }) => score > 0)
    .sort((a, b) => b.score - a.score || a.i - b.i)
    .slice(0, most)
    .map(({ item }) => item);
}
