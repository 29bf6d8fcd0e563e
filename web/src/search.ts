/** How well words that were typed fit a title: all of them must be in it, in any order. */

/** 0: not at all; larger is better: at the beginning, at the beginning of a word, anywhere. */
export function scoreOf(query: string, title: string): number {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  const text = title.toLowerCase();
  let score = 1;
  for (const word of words) {
    const at = text.indexOf(word);
    if (at < 0) return 0;
    score += at === 0 ? 8 : /\W/.test(text[at - 1]!) ? 4 : 1;
    if (text.length === word.length) score += 8;
  }
  return score - text.length / 1000;
}

/** The best first; of equal ones the order stays. */
export function findBest<T>(query: string, items: readonly T[], titleOf: (item: T) => string, most: number): T[] {
  if (!query.trim()) return items.slice(0, most);
  return items
    .map((item, i) => ({ item, i, score: scoreOf(query, titleOf(item)) }))
    .filter(({ score }) => score > 0)
    .sort((a, b) => b.score - a.score || a.i - b.i)
    .slice(0, most)
    .map(({ item }) => item);
}
