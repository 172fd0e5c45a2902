from pathlib import Path
from helpers import rolling
p=Path('.')
rolling.write_record(p/'roll.csv', 1, (0.1,0.0))
(p/'system.toml').write_text(rolling.SYSTEM+rolling.ROWS); (p/'system.py').write_text(rolling.PROGRAM)
(p/'own.toml').write_text(rolling.STUDY)
