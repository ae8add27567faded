/** A camera's picture with the frame's points in their labels' colours, or with labels as a mask. */
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import { drawDepth } from '../../cameras/depth-picture';
import { Lens } from '../../cameras/lens';
import {
  openPainter,
  pictureBrush,
  type PicturePainter,
  pictureTool,
} from '../../cameras/painting';
import { placeOf, Projected, UNLABELLED, type ColourOf } from '../../cameras/projected';
import { labelChanges, questionPiece, largeCamera, largeOpacity, maskShown, outlines, pictures, pointAt, clearPointed, pointed, projectedFrame } from '../../cameras/state'; // prettier-ignore
import { aimAt, lightUp } from '../../cameras/strip';
import type { CloudFrame } from '../../cloud/points/frame';
import { parseColor, type Rgb } from '../../common/colors';
import { apiBytes, apiUrl } from '../../net/rest';
import { numbersOfRuns } from '../../protocol/codec';
import type { Camera } from '../../protocol/values';
import { actions } from '../../store/actions';
import { state } from '../../store/state';
import { Button } from '../parts/controls';
import { LargeControls } from './camera-controls';

/** Width of the raster that points are drawn in, pixels, and that of the large picture. */
const [RASTER, LARGE_RASTER] = [480, 960];
/** Greatest distance of the pointer from a point's pixel, pixels of the raster. */
const REACH = 9;

/** Style of masks over the picture. */
const SEE_THROUGH = { opacity: 'var(--dimmed)' };

interface CameraProps {
  picture: Camera;
  /** The picture lies over the cloud. */
  large: boolean;
}

export function CameraPicture({ picture, large }: CameraProps) {
  const shift = state.sequence.value?.shift ?? null;
  const lens = useMemo(() => shift && Lens.of(picture, shift), [picture, shift]);
  const { width, height, name } = picture;
  return (
    <figure class="camera" style={large ? { opacity: largeOpacity.value } : {}}>
      <div class="camera-picture" style={{ aspectRatio: `${width} / ${height}`, '--ratio': width / height }}>
        {pictures.value?.drawn ? <DepthPicture picture={picture} /> : <img src={apiUrl(pathOf('images', name))} alt={`Picture of camera ${name}`} draggable={false} />}
        {lens && <Layers picture={picture} lens={lens} large={large} />}
      </div>
      <figcaption class="line wrap soft small">
        {name}
        {!lens && <span class="soft"> · not calibrated: no points</span>}
        <span class="spacer" />
        {large && <LargeControls calibrated={lens !== null} />}
        <Button
          icon={large ? 'close' : 'rectangle'}
          tip={large ? 'Close the large picture' : `Show the picture of ${name} large, over the cloud`}
          small
          onClick={() => (largeCamera.value = large ? null : name)}
        />
      </figcaption>
    </figure>
  ); // prettier-ignore
}

/** The layers over the picture of a calibrated camera. */
function Layers({ picture, lens, large }: PointsProps) {
  return (
    <>
      {large && maskShown.value && <Mask picture={picture} />}
      <Points picture={picture} lens={lens} large={large} />
      <Outlines lens={lens} />
      {large && pictureTool.value !== 'choose' && <Ink picture={picture} />}
      <Spot lens={lens} />
    </>
  );
}

function pathOf(kind: 'images' | 'masks', camera: string): string {
  const { sequence, frame } = pictures.value!;
  return `sequences/${sequence}/frames/${frame}/${kind}/${encodeURIComponent(camera)}`;
}

/** The labels as filled areas, which the server draws again after each change. */
function Mask({ picture: { name } }: { picture: Camera }) {
  const [source, setSource] = useState('');
  const path = `${pathOf('masks', name)}?format=picture`;
  useEffect(() => {
    const abort = new AbortController();
    void apiBytes('GET', path, undefined, abort.signal).then(
      (bytes) => setSource(URL.createObjectURL(new Blob([bytes]))),
      () => undefined, // the next change of labels loads it again
    );
    return () => abort.abort();
  }, [path, labelChanges.value]);
  useEffect(() => () => URL.revokeObjectURL(source), [source]);
  return (
    source && <img class="camera-mask" src={source} alt="" style={SEE_THROUGH} draggable={false} />
  );
}

/** The picture of a depth camera, drawn from its points. */
function DepthPicture({ picture }: { picture: Camera }) {
  const { width, height, name } = picture;
  const canvas = useRef<HTMLCanvasElement>(null);
  const shown = projectedFrame.value;
  useEffect(() => {
    const pen = canvas.current?.getContext('2d');
    const image = shown?.frame.images[pictures.peek()!.cameras.indexOf(picture)];
    if (!pen || !image) return;
    const pixels = new ImageData(width, height);
    drawDepth(image, pixels);
    pen.putImageData(pixels, 0, 0);
  }, [shown]);
  return <canvas ref={canvas} width={width} height={height} role="img" aria-label={`Picture of camera ${name}`} />; // prettier-ignore
}

interface PointsProps extends CameraProps {
  lens: Lens;
}

/** The frame's points over the picture, which the pointer acts on. */
function Points({ picture, lens, large }: PointsProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const { drawn } = pictures.value!;
  const [raster] = useState(() => rasterOf(picture, large ? LARGE_RASTER : RASTER, drawn));
  const shown = projectedFrame.value;
  const colours = useColours();
  const piece = questionPiece.value;
  const masked = large && maskShown.value;
  const active = state.activeLabel.value;
  const chooses = pictureTool.value === 'choose';
  useEffect(() => {
    const pen = canvas.current?.getContext('2d');
    if (!pen || !shown) return;
    raster.draw(shown.frame, lens, colours);
    if (masked) pen.clearRect(0, 0, raster.width, raster.height);
    else pen.putImageData(raster.pixels, 0, 0);
    const inPiece = piece?.frame === shown.frame.index && numbersOfRuns(piece.runs);
    const edge = masked ? chooses && shown.frame.pointsOf(active) : inPiece;
    if (edge) raster.outline(pen, shown.frame, lens, edge);
  }, [lens, shown, colours, piece, masked, active, chooses]);

  const pointUnder = (event: MouseEvent): PointUnder | null => {
    const box = canvas.current?.getBoundingClientRect();
    if (!box || !shown) return null;
    const u = Math.floor(((event.clientX - box.left) / box.width) * raster.width);
    const v = Math.floor(((event.clientY - box.top) / box.height) * raster.height);
    const point = raster.nearest(u, v, REACH);
    const place = point < 0 ? null : placeOf(shown.frame, point);
    return place && { frame: shown.frame, point, place };
  };
  const hover = (event: MouseEvent): void => {
    const under = pointUnder(event);
    if (under) pointAt(under.place, 'picture');
    else clearPointed('picture');
  };
  const click = (event: MouseEvent): void => {
    const under = pointUnder(event);
    if (!under || (masked && selectAt(under))) return;
    aimAt(under.place, lens);
  };
  return (
    <canvas
      ref={canvas}
      width={raster.width}
      height={raster.height}
      onPointerMove={hover}
      onPointerLeave={() => clearPointed('picture')}
      onClick={click}
    />
  );
}

/** The point under the pointer; `place`: local metres. */
interface PointUnder {
  readonly frame: CloudFrame;
  readonly point: number;
  readonly place: [number, number, number];
}

/** Choose the label of a point and light it up in the cloud; return false if it has none. */
function selectAt({ frame, point }: PointUnder): boolean {
  const label = frame.storedLabelOf(point);
  if (!state.palette.peek().some(({ id }) => id === label)) return false;
  actions.labels.selectLabel(label);
  lightUp(label);
  return true;
}

/** The painted pixels before they are sent, and the brush under the pointer. */
function Ink({ picture }: { picture: Camera }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const painter = useRef<PicturePainter>(null);
  const [at, setAt] = useState<readonly [number, number] | null>(null);
  useEffect(() => {
    painter.current = openPainter(canvas.current!, picture);
    return () => painter.current?.dispose();
  }, [picture]);
  const move = (event: PointerEvent): void => {
    painter.current?.move(event);
    setAt([event.offsetX, event.offsetY]);
  };
  const ring = at &&
    pictureTool.value === 'brush' && {
      left: `${at[0]}px`,
      top: `${at[1]}px`,
      width: `${200 * pictureBrush.value}%`,
      height: 'auto',
      aspectRatio: '1',
    };
  return (
    <>
      <canvas
        ref={canvas}
        width={LARGE_RASTER}
        height={heightOf(picture, LARGE_RASTER)}
        style={{ touchAction: 'none' }}
        onPointerDown={(event) => painter.current?.press(event)}
        onPointerMove={move}
        onPointerUp={() => painter.current?.release()}
        onPointerCancel={() => painter.current?.cancel()}
        onPointerLeave={() => setAt(null)}
      />
      {ring && <span class="camera-spot" style={ring} />}
    </>
  ); // prettier-ignore
}

/** Return the raster of a picture; `clear`: unlabelled points do not cover it. */
function rasterOf(picture: Camera, across: number, clear: boolean): Projected {
  return new Projected(across, heightOf(picture, across), clear ? 0 : UNLABELLED);
}

function heightOf({ width, height }: Camera, across: number): number {
  return Math.max(1, Math.round((across * height) / width));
}

/** The place under the pointer, in the cloud or in a picture. */
function Spot({ lens }: { lens: Lens }) {
  const at = pointed.value;
  if (!at || !lens.project(...at.place)) return null;
  const { width, height } = lens.picture;
  const style = {
    left: `${(lens.at[0]! / width) * 100}%`,
    top: `${(lens.at[1]! / height) * 100}%`,
  };
  return <span class="camera-spot" style={style} />;
}

/** The outlines of boxes in the picture. */
function Outlines({ lens }: { lens: Lens }) {
  const { width, height } = lens.picture;
  if (outlines.value.length === 0) return null;
  return (
    <svg class="camera-outlines" viewBox={`0 0 ${width} ${height}`} preserveAspectRatio="none">
      {outlines.value.map(({ color, chosen, dashed, ends }, i) => (
        <path key={i} d={lens.lines(ends)} stroke={color} class={`${chosen ? 'chosen' : ''} ${dashed ? 'dashed' : ''}`} />
      ))}
    </svg>
  ); // prettier-ignore
}

const PLAIN: Rgb = [255, 255, 255];

/** Return the colours of the visible labels. */
function useColours(): ColourOf {
  const palette = state.palette.value;
  const solo = state.solo.value;
  const hideUnlabeled = state.view.value.hideUnlabeled;
  return useMemo(() => {
    const rgb = new Map(
      palette
        .filter(({ id, visible }) => (solo === null ? visible : id === solo))
        .map(({ id, color }) => [id, parseColor(color)] as const),
    );
    return (label: number) => (label === 0 ? (hideUnlabeled ? null : PLAIN) : (rgb.get(label) ?? null)); // prettier-ignore
  }, [palette, solo, hideUnlabeled]);
}
