/** Controls of the large picture: mask, painting, opacity. */
import { pictureBrush, pictureTool, type PictureTool } from '../../cameras/painting';
import { largeOpacity, maskShown } from '../../cameras/state';
import { canEdit } from '../../store/state';
import { Button, Slider } from '../parts/controls';
import { RadioGroup, type RadioOption } from '../parts/radio-group';

const TOOLS: readonly RadioOption<PictureTool>[] = [
  { value: 'choose', icon: 'target', label: 'Look', tip: 'Click: choose a label, or look at the place' },
  { value: 'brush', icon: 'brush', label: 'Brush', tip: 'Paint pixels: their points get the label' },
  { value: 'polygon', icon: 'polygon', label: 'Polygon', tip: 'Click the corners of an outline' },
  { value: 'rectangle', icon: 'rectangle', label: 'Box', tip: 'Drag a box from corner to corner' },
]; // prettier-ignore

/** Bounds of the brush's radius, as shares of the picture's width. */
const [SMALLEST, LARGEST] = [0.003, 0.12];

export function LargeControls({ calibrated }: { calibrated: boolean }) {
  return (
    <>
      {calibrated && <Button label="Mask" icon="layers" small tip="Labels as filled areas of the picture" pressed={maskShown.value} onClick={() => (maskShown.value = !maskShown.value)} />}
      {calibrated && canEdit.value && <RadioGroup label="In the picture" class="segmented" options={TOOLS} value={pictureTool.value} onChoose={(tool) => (pictureTool.value = tool)} />}
      {pictureTool.value === 'brush' && <Slider label="Size" value={pictureBrush.value} min={SMALLEST} max={LARGEST} logarithmic tip="Size of the brush in the picture" onInput={(radius) => (pictureBrush.value = radius)} />}
      <Slider label="Opacity" value={largeOpacity.value} min={0.15} max={1} tip="A lower value shows more of the cloud" onInput={(opacity) => (largeOpacity.value = opacity)} />
    </>
  ); // prettier-ignore
}
