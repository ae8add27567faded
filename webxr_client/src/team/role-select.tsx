/** Choice of a role; roles above the own one are not offered, as the server refuses them. */
import { ROLES, state } from '../store/state';

interface RoleSelectProps {
  of: string;
  value: string;
  onChange: (role: string) => void;
}

export function RoleSelect({ of, value, onChange }: RoleSelectProps) {
  const own = ROLES.indexOf(state.me.value?.role ?? 'admin');
  const offered = ROLES.filter((role, rank) => rank <= own || role === value);
  return (
    <select
      class="field"
      aria-label={`Role of ${of}`}
      value={value}
      onChange={(event) => onChange(event.currentTarget.value)}
    >
      {offered.map((role) => (
        <option key={role} value={role}>
          {role}
        </option>
      ))}
    </select>
  );
}
