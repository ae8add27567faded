/** Break text at blanks into lines of at most so many letters; a longer word keeps its line. */
export function lines(text: string, letters: number): string[] {
  const found = [''];
  for (const word of text.split(/\s+/u)) {
    const last = found.at(-1)!;
    if (last && last.length + 1 + word.length > letters) found.push(word);
    else found[found.length - 1] = last ? `${last} ${word}` : word;
  }
  return found.filter(Boolean);
}
