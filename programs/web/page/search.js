// Why a search of the whole picture found no landmark, in words: by the dark spots that it saw, and by the guess that
// came nearest to a landmark.
// Smaller ones are seen in good light alone.
const SMALL_PX = 4;

export const isSeen = (dot) => dot[5] > 0;
const seenOf = (search) => search.dots.filter(isSeen).length;
export const hasGuess = (search) => search.refusal > 0;

const WHAT_TO_DO = {
  1: (search) => `${seenOf(search)} of the nine are there: clear the view of the others, or look at the sheet less from the side.`,
  2: (search) => `Ink and paper are ${search.contrast.toFixed(0)} grey levels apart, the noise is ${search.noise.toFixed(1)}: more light.`,
  3: () => "Is it printed as `ninedot pattern` makes it, on white paper?",
  4: () => "Clear the view of its middle; or it is another pattern.",
  5: () => "Is it clean, and printed as `ninedot pattern` makes it?",
  6: () => "It is bent, soiled, out of focus, or another pattern.",
};

// search: as the live feed has it
export function whyNothing(search) {
  const spots = `${search.spots_seen} dark spot${search.spots_seen === 1 ? "" : "s"}`;
  if (search.spots_seen < 4) return `${spots} in all of the picture: is the lens open, and the sheet in view, lit and in focus?`;
  if (!hasGuess(search)) return `${spots}, outlined, but no nine that lie like a landmark's: is the whole sheet in view, sharp, and printed as \`ninedot pattern\` makes it?`;
  const across = Math.min(...search.dots.filter(isSeen).map((dot) => 2 * dot[3]));
  const small = across < SMALL_PX ? ` Its dots are ${across.toFixed(1)} px across: come nearer.` : "";
  return `What comes nearest is outlined: ${search.why}. ${WHAT_TO_DO[search.refusal]?.(search) ?? ""}${small}`;
}
