/** One of the masks that are about to be imported, over the picture that it was made of. */
import { useEffect, useRef, useState } from 'preact/hooks';
import { parseColor } from '../../common/colors';
import { api, apiUrl } from '../../net/rest';
import type { Camera } from '../../protocol/values';
import { labelColours } from '../../store/safe-colours';
import type { ImportDraft } from '../../store/state';

interface Shown {
  readonly image: ImageBitmap;
  readonly name: string;
  /** Address of the picture; null: the recording has none of this camera. */
  readonly picture: string | null;
}

export function MaskPreview({ draft }: { draft: ImportDraft }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [shown, setShown] = useState<Shown | null>(null);
  useEffect(() => void preview(draft).then(setShown, () => setShown(null)), [draft.labels]);
  useEffect(() => {
    if (shown && canvas.current) colour(canvas.current, shown.image);
  }, [shown]);
  if (!shown) return null;
  const { image, name, picture } = shown;
  return (
    <figure>
      <div class="camera-picture" style={{ aspectRatio: `${image.width} / ${image.height}`, maxHeight: 'var(--list-s)', marginInline: 'auto' }}>
        {picture && <img src={picture} alt={`Picture of ${name}`} draggable={false} />}
        <canvas ref={canvas} style={{ opacity: 'var(--dimmed)' }} width={image.width} height={image.height} role="img" aria-label={`Mask ${name}`} />
      </div>
      <figcaption class="soft small">{name}</figcaption>
    </figure>
  ); // prettier-ignore
}

/** The first mask that is an image and has a frame. */
async function preview({ files, labels, sequence }: ImportDraft): Promise<Shown | null> {
  for (const { file, frame } of labels?.files ?? []) {
    const chosen = files?.find(({ path }) => path.endsWith(file) || file.endsWith(path));
    if (!chosen || !/\.png$/i.test(chosen.path)) continue;
    const image = await createImageBitmap(chosen.file, { colorSpaceConversion: 'none' });
    const base = `sequences/${encodeURIComponent(sequence!)}/frames/${frame}`;
    const cameras = await api<Camera[]>('GET', `${base}/cameras`);
    const parts = chosen.path.split(/[/.]/);
    const camera = cameras.find(({ name }) => parts.includes(name)) ?? (cameras.length === 1 ? cameras[0] : null); // prettier-ignore
    const picture = camera ? apiUrl(`${base}/images/${encodeURIComponent(camera.name)}`) : null;
    return { image, name: `${chosen.path} · frame ${frame}`, picture };
  }
  return null;
}

/** Draw a mask: greys, which are numbers of classes or objects, get colours; black is clear. */
function colour(canvas: HTMLCanvasElement, image: ImageBitmap): void {
  const pen = canvas.getContext('2d', { willReadFrequently: true })!;
  pen.drawImage(image, 0, 0);
  const pixels = pen.getImageData(0, 0, image.width, image.height);
  const words = new Uint32Array(pixels.data.buffer);
  const colours = new Map<number, number>();
  words.forEach((word, i) => {
    const [red, green, blue] = [word & 255, (word >> 8) & 255, (word >> 16) & 255];
    if (red + green + blue === 0) words[i] = 0;
    if (red !== green || green !== blue || red === 0) return;
    if (!colours.has(red))
      colours.set(red, wordOf(labelColours.peek()[colours.size % labelColours.peek().length]!));
    words[i] = colours.get(red)!;
  });
  pen.putImageData(pixels, 0, 0);
}

/** Return the opaque pixel of a colour "#rrggbb" in the order of memory. */
function wordOf(color: string): number {
  const [red, green, blue] = parseColor(color);
  return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}
