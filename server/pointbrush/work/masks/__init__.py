"""Labels of a recording's points from masks of its pictures, and masks from labels."""
