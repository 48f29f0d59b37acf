"""Print the JSON schema of the config."""

import json

from rockdamp.config.model import Config

print(json.dumps(Config.model_json_schema(), indent=2))
