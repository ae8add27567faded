"""The object tool: frames prepared in advance, and nested candidates for clicks."""
