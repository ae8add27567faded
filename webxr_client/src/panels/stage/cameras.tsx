/** The strip of cameras beside the cloud: pictures with the frame's points in their labels' colours. */
import { computed } from '@preact/signals';
import { useEffect, useLayoutEffect, useMemo, useRef, useState } from 'preact/hooks';
import { Lens } from '../../cameras/lens';
import { placeOf, Projected, type ColourOf } from '../../cameras/projected';
import { questionPiece, largeCamera, largeOpacity, outlines, pictures, pointAt, clearPointed, pointed, projectedFrame, stripOpen } from '../../cameras/state'; // prettier-ignore
import { aimAt } from '../../cameras/strip';
import { apiUrl } from '../../net/rest';
import type { Camera } from '../../protocol/values';
import { state } from '../../store/state';
import { percent } from '../../common/format';
import { Button, Slider } from '../parts/controls';

/** Pixels of the raster that points are drawn in, across. */
const RASTER = 480;
const LARGE_RASTER = 960;
/** Greatest distance of the pointer from a point's pixel, pixels of the raster. */
const REACH = 9;

/** Whether the recording has pictures: their room is kept from the start. */
const pictured = computed(
  () => state.sequence.value?.cameras || (pictures.value?.cameras.length ?? 0) > 0,
);

/** In the tool bar's second row, where the recording has pictures. */
export function CamerasButton() {
  if (!pictured.value) return null;
  return (
    <Button
      icon="camera"
      label="Pictures"
      tip="Pictures of the cameras, with the points in them"
      pressed={stripOpen.value}
      onClick={() => (stripOpen.value = !stripOpen.value)}
    />
  );
}

export function CameraPanel() {
  const found = pictures.value;
  const open = stripOpen.value && pictured.value;
  useLayoutEffect(() => {
    const stage = document.getElementById('stage')!;
    stage.classList.toggle('with-cameras', open);
    return () => stage.classList.remove('with-cameras');
  }, [open]);
  if (!open) return null;
  const cameras = found?.cameras ?? [];
  const sourceOf = ({ name }: Camera): string =>
    apiUrl(
      `sequences/${found!.sequence}/frames/${found!.frame}/images/${encodeURIComponent(name)}`,
    );
  const large = cameras.find(({ name }) => name === largeCamera.value);
  return (
    <>
      <section class="cameras" aria-label="Cameras">
        {cameras.map((picture) => (
          <Camera key={picture.name} picture={picture} source={sourceOf(picture)} large={false} />
        ))}
        {found && cameras.length === 0 && <p class="soft empty">No picture of this frame.</p>}
      </section>
      {large && (
        <section class="camera-large" aria-label={`Camera ${large.name}, large`}>
          <Camera key={large.name} picture={large} source={sourceOf(large)} large />
        </section>
      )}
    </>
  );
}

interface CameraProps {
  picture: Camera;
  source: string;
  /** It lies over the cloud. */
  large: boolean;
}

function Camera({ picture, source, large }: CameraProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const shift = state.sequence.value?.shift ?? null;
  const lens = useMemo(() => shift && Lens.of(picture, shift), [picture, shift]);
  const [raster] = useState(() => rasterOf(picture, large ? LARGE_RASTER : RASTER));
  const shown = projectedFrame.value;
  const colours = useColours();
  const piece = questionPiece.value;
  useEffect(() => {
    const pen = canvas.current?.getContext('2d');
    if (!pen || !lens || !shown) return;
    raster.draw(shown.frame, lens, colours);
    pen.putImageData(raster.pixels, 0, 0);
    if (piece?.frame === shown.frame.index) raster.outline(pen, shown.frame, lens, piece.runs);
  }, [lens, shown, colours, piece]);

  /** The point under the pointer, and where it is. */
  const under = (event: MouseEvent): [number, number, number] | null => {
    const box = canvas.current?.getBoundingClientRect();
    if (!box || !shown) return null;
    const u = Math.floor(((event.clientX - box.left) / box.width) * raster.width);
    const v = Math.floor(((event.clientY - box.top) / box.height) * raster.height);
    const point = raster.nearest(u, v, REACH);
    return point < 0 ? null : placeOf(shown.frame, point);
  };
  const hover = (event: MouseEvent): void => {
    const place = under(event);
    if (place) pointAt(place, 'picture');
    else clearPointed('picture');
  };
  const click = (event: MouseEvent): void => {
    const place = under(event);
    if (place && lens) aimAt(place, lens);
  };
  return (
    <figure class="camera" style={large ? { opacity: largeOpacity.value } : {}}>
      <div class="camera-picture" style={{ aspectRatio: `${picture.width} / ${picture.height}` }}>
        <img src={source} alt={`Picture of camera ${picture.name}`} draggable={false} />
        <canvas
          ref={canvas}
          width={raster.width}
          height={raster.height}
          onPointerMove={hover}
          onPointerLeave={() => clearPointed('picture')}
          onClick={click}
        />
        {lens && <Outlines lens={lens} />}
        {lens && <Spot lens={lens} />}
      </div>
      <figcaption class="line soft small">
        {picture.name}
        {!lens && <span class="soft"> · not calibrated: no points</span>}
        <span class="spacer" />
        {large && <Opacity />}
        <Button
          icon={large ? 'close' : 'rectangle'}
          tip={
            large
              ? 'Close the large picture'
              : `Show the picture of ${picture.name} large, over the cloud`
          }
          small
          onClick={() => (largeCamera.value = large ? null : picture.name)}
        />
      </figcaption>
    </figure>
  );
}

function Opacity() {
  return (
    <Slider
      label="Opacity"
      value={largeOpacity.value}
      min={0.15}
      max={1}
      tip="A lower value shows more of the cloud"
      shown={percent(largeOpacity.value)}
      onInput={(opacity) => (largeOpacity.value = opacity)}
    />
  );
}

function rasterOf({ width, height }: Camera, across: number): Projected {
  return new Projected(across, Math.max(1, Math.round((across * height) / width)));
}

/** The place under the pointer. */
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

/** Boxes as the camera sees them. */
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

const PLAIN = [255, 255, 255] as const;

/** Colours of labels as shown now. */
function useColours(): ColourOf {
  const palette = state.palette.value;
  const solo = state.solo.value;
  const hideUnlabeled = state.view.value.hideUnlabeled;
  return useMemo(() => {
    const rgb = new Map(
      palette
        .filter(({ id, visible }) => (solo === null ? visible : id === solo))
        .map(({ id, color }) => [id, rgbOf(color)] as const),
    );
    return (label: number) => (label === 0 ? (hideUnlabeled ? null : PLAIN) : (rgb.get(label) ?? null)); // prettier-ignore
  }, [palette, solo, hideUnlabeled]);
}

function rgbOf(color: string): readonly [number, number, number] {
  const number = Number.parseInt(color.slice(1), 16);
  return [number >> 16, (number >> 8) & 255, number & 255];
}
