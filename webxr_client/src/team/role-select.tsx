/** Choice of a person's role. */
import { ROLES } from '../store/state';

interface RoleSelectProps {
  of: string;
  value: string;
  onChange: (role: string) => void;
}

export function RoleSelect({ of, value, onChange }: RoleSelectProps) {
  return (
    <select
      class="field"
      aria-label={`Role of ${of}`}
      value={value}
      onChange={(event) => onChange(event.currentTarget.value)}
    >
      {ROLES.map((role) => (
        <option key={role} value={role}>
          {role}
        </option>
      ))}
    </select>
  );
}
