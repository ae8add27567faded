/** The whole palette: labels of a template or a file, and the palette as a file. */
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { actions } from '../../store/actions';
import { canEdit, state } from '../../store/state';
import {
  addTemplate,
  loadTemplates,
  pickPalette,
  savePalette,
  templates,
} from '../../engine/labels/palette-files';
import { plural } from '../../common/format';
import { chooseSafeColours, safeColours } from '../../store/safe-colours';
import { Check } from '../parts/controls';
import { MenuItem, PopoverButton } from '../parts/popover';

const open = signal(false);

export function PaletteMenuButton() {
  return (
    <PopoverButton open={open} icon="more" tip="Templates and palette files" small label="Palette">
      <Menu />
    </PopoverButton>
  );
}

const NAMES: Readonly<Record<string, string>> = {
  semantickitti: 'SemanticKITTI',
  nuscenes: 'nuScenes',
  las: 'LAS',
  scannet: 'ScanNet',
};

function Menu() {
  useEffect(() => void loadTemplates(), []);
  const cannot = !canEdit.value;
  return (
    <>
      <h2>Add the labels of</h2>
      {templates.value.map(({ name, labels }) => (
        <MenuItem
          key={name}
          icon="layers"
          label={NAMES[name] ?? name}
          disabled={cannot}
          onClick={() => void addTemplate(name)}
        >
          <span class="end number">{plural(labels, 'label')}</span>
        </MenuItem>
      ))}
      <MenuItem
        icon="import"
        label="A palette file…"
        disabled={cannot}
        onClick={() => pickPalette()}
      />
      <hr />
      <Check
        label="Colours for colour-blind users"
        tip="New labels and the colour picker use colours that are distinct with every kind of colour blindness"
        checked={safeColours.value}
        onChange={chooseSafeColours}
      />
      <MenuItem
        icon="swap"
        label="Apply these colours to all labels"
        disabled={cannot || state.palette.value.length === 0}
        onClick={() => void actions.labels.recolorAll()}
      />
      <hr />
      <MenuItem
        icon="export"
        label="Save the palette as a file"
        disabled={state.palette.value.length === 0}
        onClick={() => void savePalette()}
      />
    </>
  );
}
